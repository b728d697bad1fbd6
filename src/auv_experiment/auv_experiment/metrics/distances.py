"""Positions of the vehicles, of their mean and of their path, and distances between them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from auv_experiment.metrics.finite import norm, smallest
from auv_experiment.recording import BoolArray, FloatArray, Recording
from auv_sim.obstacle_field import ObstacleField

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


def vehicle_pairs(n_vehicles: int) -> list[tuple[int, int]]:
    """Return the P unordered pairs of vehicle indices (i, j), i < j, in the order of all pair arrays."""
    first, second = np.triu_indices(n_vehicles, 1)
    return list(zip(first.tolist(), second.tolist(), strict=True))


def pair_distances_m(recording: Recording) -> FloatArray:
    """Return the (K + 1, P) distances between hull centres (m), lost vehicles included."""
    first, second = np.triu_indices(recording.n_vehicles, 1)
    return norm(recording.position_ned_m[:, first] - recording.position_ned_m[:, second])


def touch_distances_m(scenario: Scenario) -> FloatArray:
    """Return the (P,) distances between hull centres at which two hulls touch (m)."""
    radii_m = np.array(scenario.hull_radii_m)
    first, second = np.triu_indices(len(radii_m), 1)
    touch_m: FloatArray = radii_m[first] + radii_m[second]
    return touch_m


def warning_distances_m(scenario: Scenario) -> FloatArray:
    """Return the (P,) distances between hull centres below which a report warns (m); 0: never."""
    near_m = np.array([handling.near_m for handling in scenario.handlings])
    first, second = np.triu_indices(len(near_m), 1)
    allowed_m: FloatArray = np.maximum(near_m[first], near_m[second])
    return allowed_m


def flock_pair_distances_m(recording: Recording) -> FloatArray:
    """Return the (K + 1, P) distances between hull centres (m), NaN after the loss of either vehicle."""
    return np.where(pair_is_gone(recording), np.nan, pair_distances_m(recording))


def flock_positions_ned_m(recording: Recording) -> FloatArray:
    """Return the (K + 1, N, 3) true positions (m, map_ned), NaN after a vehicle's loss."""
    return np.where(recording.is_gone[..., np.newaxis], np.nan, recording.position_ned_m)


def centroid_ned_m(recording: Recording) -> FloatArray:
    """Return the (K + 1, 3) mean of the flock's true positions (m, map_ned), NaN if no vehicle is left."""
    positions = recording.position_ned_m
    alive = ~recording.is_gone
    total = np.where(alive[..., np.newaxis], positions, 0.0).sum(axis=1)
    count = alive.sum(axis=1)[:, np.newaxis].astype(float)
    mean: FloatArray = total / np.where(count > 0.0, count, np.nan)
    return mean


def path_ned_m(recording: Recording, scenario: Scenario) -> FloatArray:
    """Return the (K + 1, 3) positions eta_d of the flock's path (m, map_ned), NaN without a path."""
    path = scenario.reference_of()
    if path is None:
        return np.full((len(recording.t_s), 3), math.nan)
    return np.array([path.at(t_s).position for t_s in recording.t_s.tolist()], dtype=np.float64)


def centroid_path_error_m(recording: Recording, scenario: Scenario) -> FloatArray:
    """Return the (K + 1,) distances |mean of true positions - eta_d| (m)."""
    return norm(centroid_ned_m(recording) - path_ned_m(recording, scenario))


def consensus_error_m(recording: Recording) -> FloatArray:
    """Return the (K, N) distances |c_i - mean of true positions| (m), NaN after a vehicle's loss."""
    error_m = norm(recording.centre_ned_m - centroid_ned_m(recording)[:-1, np.newaxis])
    return np.where(recording.is_gone[:-1], np.nan, error_m)


def obstacle_positions_ned_m(recording: Recording, scenario: Scenario) -> FloatArray:
    """Return the (K + 1, number of obstacles, 3) positions of the obstacles (m, map_ned)."""
    field = ObstacleField(scenario.environment.obstacles)
    places = [field.at(t_s) for t_s in recording.t_s.tolist()]
    return np.array(places, dtype=np.float64).reshape(len(places), -1, 3)


def obstacle_distances_m(recording: Recording, scenario: Scenario) -> FloatArray:
    """Return the (K + 1, N, number of obstacles) distances from hull centres to obstacle centres (m)."""
    obstacles = obstacle_positions_ned_m(recording, scenario)
    return norm(recording.position_ned_m[:, :, np.newaxis] - obstacles[:, np.newaxis])


def pair_is_gone(recording: Recording) -> BoolArray:
    """Return (K + 1, P) flags: one vehicle of the pair has been lost by that time."""
    first, second = np.triu_indices(recording.n_vehicles, 1)
    gone = recording.is_gone
    return gone[:, first] | gone[:, second]


def is_working(recording: Recording, scenario: Scenario) -> BoolArray:
    """Return (K + 1, N) flags: the vehicle is not lost, and its computer has not failed."""
    fails_at_s = [np.inf if v.fails_at_s is None else v.fails_at_s for v in scenario.vehicles]
    works: BoolArray = ~recording.is_gone & (recording.t_s[:, np.newaxis] < np.array(fails_at_s))
    return works


def working_distances(recording: Recording, works: BoolArray) -> dict[str, float | None]:
    """Return the smallest distances of two working vehicles, and of a working one from one that is not."""
    first, second = np.triu_indices(recording.n_vehicles, 1)
    pairs_m = pair_distances_m(recording)
    both, only_one = works[:, first] & works[:, second], works[:, first] ^ works[:, second]
    return {
        "pair_distance_working_min_m": smallest(pairs_m[both]),
        "wreck_distance_min_m": smallest(pairs_m[only_one]),
    }
