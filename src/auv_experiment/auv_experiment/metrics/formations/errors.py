"""
Metrics of a run with the adaptive formation law.

Errors are path minus actual, as the thesis's figures plot them; those of one vehicle are the first one's. The
thesis's distances are signed radii: d_ij = r_j - r_i with r = hypot(x, y) the distance from the vertical
through the origin, around which all its paths turn. They may be negative while a vehicle is on its way, and
are the true distances only if the vehicles lie on one ray.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from auv_experiment.metrics.finite import largest
from auv_experiment.metrics.path import (
    heading_rad,
    path_followers,
    position_error_ned_m,
    velocity_error_ned_mps,
)
from auv_experiment.recording import FloatArray, Recording

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

SETTLED_BAND = 0.05
"""Band (m, rad) in which an error, and a distance around its wanted value, counts as settled."""
AXES = ("x", "y", "z", "yaw")
LATE_AFTER_S = 100.0


def formation_metrics(recording: Recording, scenario: Scenario) -> dict[str, Any]:
    """
    Return the metrics of a run with the adaptive law.

    Parameters
    ----------
    recording : Recording
        The run.
    scenario : Scenario
        Its scenario: paths, law.

    Returns
    -------
    metrics : dict
        As `MEANINGS` describes them; empty unless the law is `adaptive` and the first vehicle has a path.
        Ranges are [smallest, largest]; yaw counts in rad and N m.

    """
    section = scenario.agent.controller
    if section.kind != "adaptive" or 0 not in path_followers(scenario):
        return {}
    t_s = recording.t_s
    error, rate = errors(recording, scenario), rate_errors(recording, scenario)
    force = recording.command[:, 0][:, (0, 1, 2, 5)]
    late = t_s > LATE_AFTER_S
    metrics: dict[str, Any] = {
        "position_err_range_m": _range(error),
        "velocity_err_range_mps": _range(rate),
        "force_range_n": _range(force),
    }
    for axis, name in enumerate(AXES):
        unit = "rad" if name == "yaw" else "m"
        metrics[f"{name}_settling_0p05_s"] = _settling_s(t_s, error[:, axis])
        metrics[f"{name}_overshoot_{unit}"] = _overshoot(error[:, axis])
    for axis, name in enumerate(AXES[:3]):
        metrics[f"{name}_force_late_n"] = largest(np.abs(force[late[:-1], axis]))
    metrics |= _distance_metrics(recording, scenario)
    names = estimate_names(scenario)
    metrics["estimate_names"] = list(names)
    metrics["estimates_final"] = recording.law_state[-1, :, : len(names)].tolist()
    metrics["adaptation_frozen_s"] = _frozen_s(recording, scenario)
    return metrics


def errors(recording: Recording, scenario: Scenario, vehicle: int = 0) -> FloatArray:
    """Return the (K + 1, 4) path minus actual of one vehicle: x, y, z (m; NED) and yaw (rad, wrapped)."""
    path: Any = scenario.reference_of(vehicle)
    wanted = np.array([path.at(t).heading_rad for t in recording.t_s.tolist()])
    yaw = np.remainder(wanted - heading_rad(recording)[:, vehicle] + np.pi, 2.0 * np.pi) - np.pi
    return np.column_stack([position_error_ned_m(recording, scenario)[:, vehicle], yaw])


def rate_errors(recording: Recording, scenario: Scenario, vehicle: int = 0) -> FloatArray:
    """Return the (K + 1, 4) rates of path minus actual of one vehicle (m/s; NED; rad/s)."""
    path: Any = scenario.reference_of(vehicle)
    wanted = np.array([path.at(t).heading_rate_radps for t in recording.t_s.tolist()])
    linear = velocity_error_ned_mps(recording, scenario)[:, vehicle]
    return np.column_stack([linear, wanted - recording.velocity_body[:, vehicle, 5]])


def signed_distances_m(recording: Recording) -> tuple[FloatArray, FloatArray]:
    """Return the (K + 1,) signed radii d12 and d23 of the first three vehicles (m)."""
    radius = np.hypot(recording.position_ned_m[..., 0], recording.position_ned_m[..., 1])
    return radius[:, 1] - radius[:, 0], radius[:, 2] - radius[:, 1]


def estimate_names(scenario: Scenario) -> tuple[str, ...]:
    """Return the names of the law's estimates, in the order of its state."""
    names: tuple[str, ...] = scenario.agent.controller.params.names
    return names


def _distance_metrics(recording: Recording, scenario: Scenario) -> dict[str, Any]:
    if recording.n_vehicles < 3 or not {1, 2} <= set(path_followers(scenario)):
        return {}
    t_s = recording.t_s
    late = t_s > LATE_AFTER_S
    d12, d23 = signed_distances_m(recording)
    wanted12, wanted23 = _wanted_distances_m(recording, scenario)
    position = recording.position_ned_m
    return {
        "d12_range_m": _range(d12),
        "d23_range_m": _range(d23),
        "d12_minus_d23_range_m": _range(d12 - d23),
        "d12_minus_d23_final_m": float(d12[-1] - d23[-1]),
        "d12_settling_0p05_s": _settling_s(t_s, d12 - wanted12),
        "d23_settling_0p05_s": _settling_s(t_s, d23 - wanted23),
        "d12_err_late_m": largest(np.abs(d12 - wanted12)[late]),
        "d23_err_late_m": largest(np.abs(d23 - wanted23)[late]),
        "d12_minus_d23_late_m": largest(np.abs(d12 - d23)[late]),
        "d12_true_range_m": _range(np.linalg.norm(position[:, 1] - position[:, 0], axis=-1)),
        "d23_true_range_m": _range(np.linalg.norm(position[:, 2] - position[:, 1], axis=-1)),
    }


def _wanted_distances_m(recording: Recording, scenario: Scenario) -> tuple[FloatArray, FloatArray]:
    """Return the (K + 1,) signed radii of the first three paths (m)."""
    radii = []
    for vehicle in range(3):
        path: Any = scenario.reference_of(vehicle)
        points = [path.at(t).position for t in recording.t_s.tolist()]
        radii.append(np.array([math.hypot(x, y) for x, y, _ in points]))
    return radii[1] - radii[0], radii[2] - radii[1]


def _frozen_s(recording: Recording, scenario: Scenario) -> float:
    """Return the time in which a command is at the law's own limit, summed over the vehicles (s)."""
    params = scenario.agent.controller.params
    force_n = math.inf if params.max_force_n is None else params.max_force_n
    moment_nm = math.inf if params.max_moment_nm is None else params.max_moment_nm
    at_limit = (np.abs(recording.command[..., :3]) >= force_n).any(axis=-1)
    at_limit |= np.abs(recording.command[..., 5]) >= moment_nm
    return float(at_limit.sum() * scenario.period_s)


def _settling_s(t_s: FloatArray, error: FloatArray) -> float | None:
    """Return the first time after which |error| stays within the band (s), None if there is none."""
    is_out = ~(np.abs(error) <= SETTLED_BAND)
    if is_out[-1]:
        return None
    return float(t_s[len(t_s) - is_out[::-1].argmax()]) if is_out.any() else float(t_s[0])


def _overshoot(error: FloatArray) -> float | None:
    """Return the largest error with the opposite sign of the first."""
    return largest(-error if error[0] >= 0.0 else error)


def _range(values: FloatArray) -> list[float] | None:
    finite = values[np.isfinite(values)]
    return [float(finite.min()), float(finite.max())] if finite.size else None
