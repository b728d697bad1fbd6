"""
Metrics of what should not happen: agents that gave the safe command, and hulls above the surface, which is
impossible for a real vehicle, but not prevented by the model of a submerged hull.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from auv_experiment.recording import Recording
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


def surface_metrics(recording: Recording, scenario: Scenario) -> dict[str, float | None]:
    """Return how long and how high hulls were in the air, without lost vehicles."""
    height_m = -recording.position_ned_m[..., 2] - scenario.hull_radius_m
    is_in_air = (height_m > 0.0) & ~recording.is_gone
    return {
        "hull_in_air_ratio": float(is_in_air.mean()),
        "hull_in_air_height_m": float(np.max(height_m[is_in_air])) if is_in_air.any() else None,
    }


def surface_warning(metrics: Mapping[str, object]) -> str:
    """Return one line for the user if hulls were in the air, otherwise an empty text."""
    share, height_m = metrics.get("hull_in_air_ratio"), metrics.get("hull_in_air_height_m")
    if not isinstance(share, float) or not isinstance(height_m, float):
        return ""
    return (
        f"hulls were above the surface, by up to {height_m:.2f} m, for {100.0 * share:.1f} % of the time "
        "of all vehicles; no real vehicle can do that"
    )
