"""
Lyapunov candidates as data: the functions that should decrease under each law, evaluated along a run.

A law names its candidates V (see `auv_control.controllers`): the printed one and, if that is wrong, a
corrected one. They are functions of the recorded motion alone: true states, the law's state, the path, the
others' true positions. If a proof holds, V decreases from record to record.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from auv_control.controllers import MotionLaw, MotionView, make_controller
from auv_core.geometry import Vec3
from auv_core.messages import VehicleState
from auv_core.models import make_continuous_model
from auv_experiment.recording import FloatArray, Recording

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

TOLERANCE_RATIO = 1e-9
"""An increase within one record below this fraction of the largest |V| does not count."""


def candidate_series(recording: Recording, scenario: Scenario) -> dict[str, FloatArray]:
    """
    Return V along a run, by the candidate's name: (K, N), or (K, 1) if the candidate is for the group.

    NaN if the law's state is not recorded, as in the first ticks of a run in real time. Empty for a flocking
    law with a velocity controller.
    """
    if scenario.follows == "velocity":
        return {}
    law = _law(scenario)
    vehicles = [_values(recording, scenario, law, index) for index in range(recording.n_vehicles)]
    stacked = np.stack(vehicles, axis=1)
    if law.shared_candidate:
        stacked = stacked.sum(axis=1, keepdims=True)
    return {name: stacked[:, :, number] for number, name in enumerate(law.candidates)}


def lyapunov_metrics(recording: Recording, scenario: Scenario) -> dict[str, Any]:
    """
    Return whether each candidate decreases along the run, and where it does not.

    Returns
    -------
    metrics : dict
        For each candidate ``<name>``, over all vehicles: ``lyapunov_<name>_falls`` (V never increases within
        one record by more than 1e-9 of its largest value), ``lyapunov_<name>_rise_ratio`` (share of the
        records in which it does), ``lyapunov_<name>_first_rise_s``, ``lyapunov_<name>_largest_rise_ratio``
        (largest increase within one record / largest value); if V increases also ``lyapunov_proof_gap``, why
        the printed proof does not cover it.

    """
    metrics: dict[str, Any] = {}
    for name, values in candidate_series(recording, scenario).items():
        metrics |= fall_metrics(f"lyapunov_{name}", values, recording.t_s)
    if metrics and not all(value for key, value in metrics.items() if key.endswith("_falls")):
        metrics["lyapunov_proof_gap"] = _law(scenario).proof_gap
    return metrics


def fall_metrics(prefix: str, values: FloatArray, t_s: FloatArray) -> dict[str, float | bool | None]:
    """
    Return ``<prefix>_falls``, ``_rise_ratio``, ``_first_rise_s`` and ``_largest_rise_ratio`` of a candidate.

    Parameters
    ----------
    prefix : str
        Prefix of the names.
    values : (K, M) array
        M series of V; NaN if it does not exist.
    t_s : (K,) or longer array
        Times of the records (s).

    """
    steps = np.diff(values, axis=0)
    scale = np.nanmax(np.abs(values), axis=0, initial=0.0)
    rises = steps > TOLERANCE_RATIO * scale
    any_rise = rises.any(axis=1)
    largest = np.nanmax(steps / np.where(scale > 0.0, scale, 1.0), initial=0.0)
    return {
        f"{prefix}_falls": not any_rise.any(),
        f"{prefix}_rise_ratio": float(rises.mean()) if rises.size else None,
        f"{prefix}_first_rise_s": float(t_s[any_rise.argmax()]) if any_rise.any() else None,
        f"{prefix}_largest_rise_ratio": float(largest),
    }


def _law(scenario: Scenario) -> MotionLaw:
    law = make_controller(scenario.agent.controller, scenario.period_s)
    assert isinstance(law, MotionLaw)
    return law


def _values(recording: Recording, scenario: Scenario, law: MotionLaw, index: int) -> FloatArray:
    """Return the (K, number of candidates) values of one vehicle."""
    energy = make_continuous_model(scenario.vehicles[index].model).kinetic_energy
    path = scenario.reference_of(index)
    obstacles = tuple(
        (obstacle.position_ned_m, obstacle.safety_distance_m)
        for obstacle in scenario.environment.obstacles
        if obstacle.known
    )
    positions = recording.position_ned_m.tolist()
    attitudes = recording.attitude_quat_wxyz[:, index].tolist()
    velocities = recording.velocity_body[:, index].tolist()
    memories = recording.law_state[:, index].tolist()
    size = int(np.isfinite(recording.law_state[:, index]).sum(axis=1).max(initial=0))
    values = np.full((recording.n_ticks, len(law.candidates)), np.nan)
    for tick, t_s in enumerate(recording.t_s[:-1].tolist()):
        places: list[Vec3] = [(x, y, z) for x, y, z in positions[tick]]
        nav = VehicleState(tick, places[index], tuple(attitudes[tick]), tuple(velocities[tick]))
        others = (*places[:index], *places[index + 1 :])
        view = MotionView(t_s, nav, None if path is None else path.at(t_s), others, obstacles)
        memory = tuple([value for value in memories[tick] if value == value])
        if len(memory) == size:
            values[tick] = law.lyapunov(memory, view, energy)
    return values
