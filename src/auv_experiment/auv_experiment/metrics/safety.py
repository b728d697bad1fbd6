"""
Metrics of what should not happen: agents that gave the safe command, vehicles that came too near, and hulls
above the surface, which is impossible for a real vehicle, but not prevented by the model of a submerged hull.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from auv_experiment.metrics.distances import pair_distances_m, warning_distances_m
from auv_experiment.metrics.finite import smallest
from auv_experiment.recording import FloatArray, Recording
from auv_flocking.holding import CAUSES

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


def safe_command_metrics(recording: Recording) -> dict[str, float | int | None]:
    """Return how often agents gave the safe command instead of the law's: a key for each of `CAUSES`."""
    holding = recording.holding
    counts = {
        f"safe_commands_{cause.replace(' ', '_')}": int((holding == number).sum())
        for number, cause in enumerate(CAUSES, start=1)
    }
    return {"safe_command_ratio": float((holding > 0).mean()) if holding.size else None, **counts}


def near_metrics(recording: Recording, scenario: Scenario) -> dict[str, float | int | None]:
    """
    Return how many pairs came nearer than a vehicle of the pair allows, and the smallest of these distances,
    lost vehicles included; nothing if no vehicle states such a distance (`Handling.near_m`).
    """
    allowed_m = warning_distances_m(scenario)
    if not allowed_m.any():
        return {}
    pairs_m = pair_distances_m(recording)
    is_near = (pairs_m < allowed_m).any(axis=0)
    return {
        "near_pairs": int(is_near.sum()),
        "near_pair_distance_min_m": smallest(pairs_m[:, is_near]),
    }


def surface_metrics(recording: Recording, scenario: Scenario) -> dict[str, float | None]:
    """Return how long and how high hulls were in the air, without lost vehicles."""
    height_m = -recording.position_ned_m[..., 2] - _reach_down_m(recording, scenario)
    is_in_air = (height_m > 0.0) & ~recording.is_gone
    return {
        "hull_in_air_ratio": float(is_in_air.mean()),
        "hull_in_air_height_m": float(np.max(height_m[is_in_air])) if is_in_air.any() else None,
    }


def _reach_down_m(recording: Recording, scenario: Scenario) -> FloatArray:
    """Return the (K + 1, N) depths of the lowest points of the hulls below their centres (m): round rods."""
    rod_m = np.array([each.hull_length_m - each.hull_diameter_m for each in scenario.handlings])
    diameter_m = np.array([each.hull_diameter_m for each in scenario.handlings])
    w, x, y, z = np.moveaxis(recording.attitude_quat_wxyz, -1, 0)
    ahead_down = 2.0 * (x * z - w * y)
    reach_m: FloatArray = 0.5 * (np.where(rod_m > 0.0, np.abs(ahead_down) * rod_m, 0.0) + diameter_m)
    return reach_m


def warnings(metrics: Mapping[str, object]) -> list[str]:
    """Return a line for the user for each thing of these that happened."""
    return [line for line in (near_warning(metrics), surface_warning(metrics)) if line]


def near_warning(metrics: Mapping[str, object]) -> str:
    """Return one line if vehicles came nearer to each other than they allow, otherwise an empty text."""
    count, nearest_m = metrics.get("near_pairs"), metrics.get("near_pair_distance_min_m")
    if not isinstance(count, int) or not isinstance(nearest_m, float):
        return ""
    pairs = "1 pair of vehicles" if count == 1 else f"{count} pairs of vehicles"
    return f"{pairs} came nearer to each other than near_m of their models, down to {nearest_m:.2f} m"


def surface_warning(metrics: Mapping[str, object]) -> str:
    """Return one line for the user if hulls were in the air, otherwise an empty text."""
    share, height_m = metrics.get("hull_in_air_ratio"), metrics.get("hull_in_air_height_m")
    if not isinstance(share, float) or not isinstance(height_m, float):
        return ""
    return (
        f"hulls were above the surface, by up to {height_m:.2f} m, for {100.0 * share:.1f} % of the time "
        "of all vehicles; no real vehicle can do that"
    )
