"""
Metrics of a path-following run.

Errors are reference minus actual, in NED, each vehicle against its own path; vehicles without a path do not
count. For several vehicles every number is that of the worst one, and the effort is the sum over all.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from auv_core.models import frame_of
from auv_experiment.metrics.distances import obstacle_positions_ned_m
from auv_experiment.metrics.finite import largest, smallest
from auv_experiment.recording import FloatArray, Recording

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

START_PHASE_S = 30.0
"""Until this time a vehicle is on its way to the path."""
SETTLING_WINDOW_S = 60.0
"""
With obstacles settling counts up to this time only, since later obstacles push the vehicle off the path
again.
"""
_TOLERANCE_S = 1e-9


def path_metrics(recording: Recording, scenario: Scenario) -> dict[str, Any]:
    """
    Return the metrics of a run whose vehicles follow paths.

    Parameters
    ----------
    recording : Recording
        The run.
    scenario : Scenario
        Its scenario: paths, obstacles, models.

    Returns
    -------
    metrics : dict
        As `MEANINGS` describes them; empty if no vehicle has a path. Settling times are the first times after
        which the error stays within the band to the end of the run, or with obstacles to 60 s; None if there
        is no such time.

    """
    followers = path_followers(scenario)
    if not followers:
        return {}
    t_s = recording.t_s
    error_m = position_error_ned_m(recording, scenario)[:, followers]
    velocity_mps = velocity_error_ned_mps(recording, scenario)[:, followers]
    distance_m = np.linalg.norm(error_m, axis=-1)
    is_start = t_s < START_PHASE_S - _TOLERANCE_S
    is_later = t_s > START_PHASE_S + _TOLERANCE_S
    until_s = SETTLING_WINDOW_S if scenario.environment.obstacles else math.inf
    window = t_s < until_s - _TOLERANCE_S

    def settling_s(errors: FloatArray, band: float) -> float | None:
        return _worst_settling_s(t_s[window], np.abs(errors[window]), band)

    return {
        "position_rms_m": largest(_rms(distance_m)),
        "position_rms_after_30s_m": largest(_rms(distance_m[~is_start])),
        "position_err_max_m": largest(distance_m[is_later]),
        "overshoot_x_m": largest(error_m[is_start, :, 0]),
        "undershoot_y_m": smallest(error_m[is_start, :, 1]),
        "velocity_err_x_peak_mps": largest(np.abs(velocity_mps[..., 0])),
        "velocity_err_y_peak_mps": largest(np.abs(velocity_mps[..., 1])),
        "x_settling_0p1m_s": settling_s(error_m[..., 0], 0.1),
        "y_settling_0p2m_s": settling_s(error_m[..., 1], 0.2),
        "y_settling_0p1m_s": settling_s(error_m[..., 1], 0.1),
        "position_settling_0p1m_s": settling_s(distance_m, 0.1),
        "velocity_settling_0p01mps_s": settling_s(np.abs(velocity_mps[..., :2]).max(axis=-1), 0.01),
        "control_effort_n2s": control_effort_n2s(recording, scenario),
        **_obstacle_metrics(recording, scenario),
    }


def path_followers(scenario: Scenario) -> list[int]:
    """Return the indices of the vehicles that have a path."""
    return [i for i in range(len(scenario.vehicles)) if scenario.reference_of(i) is not None]


def position_error_ned_m(recording: Recording, scenario: Scenario) -> FloatArray:
    """Return the (K + 1, N, 3) path minus position (m; NED); NaN without a path and after a loss."""
    error = path_points_ned(recording, scenario)[0] - recording.position_ned_m
    return np.where(recording.is_gone[..., np.newaxis], np.nan, error)


def velocity_error_ned_mps(recording: Recording, scenario: Scenario) -> FloatArray:
    """Return the (K + 1, N, 3) path velocity minus velocity (m/s; NED); NaN as for the position."""
    error = path_points_ned(recording, scenario)[1] - velocity_ned_mps(recording, scenario)
    return np.where(recording.is_gone[..., np.newaxis], np.nan, error)


def path_points_ned(recording: Recording, scenario: Scenario) -> tuple[FloatArray, FloatArray]:
    """Return the (K + 1, N, 3) positions (m) and velocities (m/s) of the vehicles' paths in NED."""
    shape = (len(recording.t_s), recording.n_vehicles, 3)
    positions, velocities = np.full(shape, np.nan), np.full(shape, np.nan)
    for i in path_followers(scenario):
        path: Any = scenario.reference_of(i)
        points = [path.at(t) for t in recording.t_s.tolist()]
        positions[:, i] = [point.position for point in points]
        velocities[:, i] = [point.velocity for point in points]
    return positions, velocities


def velocity_ned_mps(recording: Recording, scenario: Scenario) -> FloatArray:
    """Return the (K + 1, N, 3) velocities of the hulls over ground (m/s; NED), also of flat plants."""
    velocity = recording.velocity_body[..., :3]
    turned = _body_to_ned(recording.attitude_quat_wxyz, velocity)
    is_flat = [frame_of(vehicle.model.params) == "flat" for vehicle in scenario.vehicles]
    return np.where(np.array(is_flat)[:, np.newaxis], velocity, turned)


def heading_rad(recording: Recording) -> FloatArray:
    """Return the (K + 1, N) headings (rad, in (-pi, pi], from north towards east)."""
    w, x, y, z = np.moveaxis(recording.attitude_quat_wxyz, -1, 0)
    heading: FloatArray = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return heading


def control_effort_n2s(recording: Recording, scenario: Scenario) -> float | None:
    """Return the sum of X^2 + Y^2 + Z^2 times the period over all vehicles (N^2 s); None without wrenches."""
    forces_n = recording.command[..., :3]
    if scenario.kinematic or not np.isfinite(forces_n).any():
        return None
    return float(np.nansum(forces_n**2) * scenario.period_s)


def _obstacle_metrics(recording: Recording, scenario: Scenario) -> dict[str, list[float]]:
    if not scenario.environment.obstacles:
        return {}
    centres = obstacle_positions_ned_m(recording, scenario)
    distances_m = np.linalg.norm(recording.position_ned_m[:, :, np.newaxis] - centres[:, np.newaxis], axis=-1)
    nearest_m = np.where(np.isnan(distances_m), np.inf, distances_m).min(axis=1)
    return {
        "obstacle_clearance_m": nearest_m.min(axis=0).tolist(),
        "obstacle_closest_at_s": recording.t_s[nearest_m.argmin(axis=0)].tolist(),
    }


def _body_to_ned(quaternions: FloatArray, vectors: FloatArray) -> FloatArray:
    axis = quaternions[..., 1:]
    twice = 2.0 * np.cross(axis, vectors)
    turned: FloatArray = vectors + quaternions[..., :1] * twice + np.cross(axis, twice)
    return turned


def _worst_settling_s(t_s: FloatArray, sizes: FloatArray, band: float) -> float | None:
    """Return the first time after which every column of `sizes` stays below `band` (s), None without one."""
    is_out = np.any(np.nan_to_num(sizes, nan=0.0) >= band, axis=1)
    if not len(t_s) or is_out[-1]:
        return None
    return float(t_s[len(t_s) - is_out[::-1].argmax()]) if is_out.any() else float(t_s[0])


def _rms(columns: FloatArray) -> FloatArray:
    """Return the root mean square of every column, NaN for an empty one."""
    exists = np.isfinite(columns)
    count = exists.sum(axis=0).astype(np.float64)
    total = np.where(exists, columns**2, 0.0).sum(axis=0)
    rms: FloatArray = np.sqrt(np.divide(total, count, out=np.full_like(total, np.nan), where=count > 0.0))
    return rms
