"""
Metrics of a run to a safe region.

The region is the ring of the law. Lists have one entry per vehicle, in the scenario's order; None means that
the event did not happen.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from auv_control.region import Ring
from auv_experiment.recording import BoolArray, FloatArray, Recording

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


REACHED_M = 0.05
"""The force vanishes at the ring's edge, so vehicles approach it slowly; this distance counts as reached."""


def region_metrics(recording: Recording, scenario: Scenario) -> dict[str, Any]:
    """
    Return the metrics of a run whose vehicles steer to a region.

    Parameters
    ----------
    recording : Recording
        The run.
    scenario : Scenario
        Its scenario: the ring and the bounds of the law.

    Returns
    -------
    metrics : dict
        As `MEANINGS` describes them; empty if the law steers to no ring.

    """
    ring = ring_of(scenario)
    if ring is None:
        return {}
    t_s = recording.t_s
    to_ring_m = ring_distances_m(recording, ring)
    to_axis_m = axis_distances_m(recording, ring)
    return {
        "pair_distance_min_at_s": _closest_at_s(recording),
        "ring_first_inside_s": [_first_s(t_s, column <= 0.0) for column in to_ring_m.T],
        "ring_reached_s": [_stays_from_s(t_s, column <= REACHED_M) for column in to_ring_m.T],
        "ring_distance_final_m": to_ring_m[-1].tolist(),
        "axis_distance_final_m": to_axis_m[-1].tolist(),
        "position_final_ned_m": recording.position_ned_m[-1].tolist(),
        "speed_max_mps": float(speeds_mps(recording).max(initial=0.0)),
        "force_max_n": float(forces_n(recording).max(initial=0.0)),
    }


def ring_of(scenario: Scenario) -> Ring | None:
    """Return the ring that the scenario's law steers to, None for another law."""
    ring = getattr(scenario.agent.controller.params, "ring", None)
    return ring if isinstance(ring, Ring) else None


def axis_distances_m(recording: Recording, ring: Ring) -> FloatArray:
    """Return the (K + 1, N) distances of the hull centres to the ring's axis (m)."""
    offset = recording.position_ned_m - np.asarray(ring.centre_ned_m)
    distances: FloatArray = np.hypot(offset[..., 0], offset[..., 1])
    return distances


def ring_distances_m(recording: Recording, ring: Ring) -> FloatArray:
    """Return the (K + 1, N) distances of the hull centres to the nearest point of the ring (m), 0 in it."""
    axis_m = axis_distances_m(recording, ring)
    above_m = np.abs(recording.position_ned_m[..., 2] - ring.centre_ned_m[2]) - 0.5 * ring.height_m
    level_m = np.maximum(np.maximum(ring.inner_radius_m - axis_m, axis_m - ring.outer_radius_m), 0.0)
    distances: FloatArray = np.hypot(level_m, np.maximum(above_m, 0.0))
    return distances


def speeds_mps(recording: Recording) -> FloatArray:
    """Return the (K + 1, N) speeds over ground (m/s), without values that do not exist."""
    speeds: FloatArray = np.linalg.norm(np.nan_to_num(recording.velocity_body[..., :3]), axis=-1)
    return speeds


def forces_n(recording: Recording) -> FloatArray:
    """Return the (K, N) magnitudes of the commanded force (N), 0 without a command."""
    forces: FloatArray = np.linalg.norm(np.nan_to_num(recording.command[..., :3]), axis=-1)
    return forces


def _closest_at_s(recording: Recording) -> float | None:
    first, second = np.triu_indices(recording.n_vehicles, 1)
    gaps = recording.position_ned_m[:, first] - recording.position_ned_m[:, second]
    squares_m2 = np.nan_to_num((gaps * gaps).sum(axis=-1), nan=np.inf)
    if not np.isfinite(squares_m2).any():
        return None
    return float(recording.t_s[squares_m2.min(axis=1).argmin()])


def _first_s(t_s: FloatArray, is_true: BoolArray) -> float | None:
    return float(t_s[is_true.argmax()]) if is_true.any() else None


def _stays_from_s(t_s: FloatArray, is_true: BoolArray) -> float | None:
    """Return the first time after which `is_true` holds to the end (s)."""
    if not is_true[-1]:
        return None
    return float(t_s[len(t_s) - is_true[::-1].argmin()]) if not is_true.all() else float(t_s[0])
