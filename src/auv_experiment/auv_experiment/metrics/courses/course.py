"""
Metrics of a run whose vehicles follow a course: heading, depth and the distance beside the path.

An error is what the course asks for minus the true value. An overshoot is the largest error of the other sign
after the largest error. Every number is that of the worst vehicle.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from auv_control.courses import make_course
from auv_experiment.metrics.finite import largest, rms
from auv_experiment.metrics.path import heading_rad
from auv_experiment.metrics.windows import GATHERED_AFTER_S, after
from auv_experiment.recording import BoolArray, FloatArray, Recording
from auv_flocking.course_task import CROSS_TRACK, DEPTH, HEADING

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

_HEADING_BAND_RAD = np.radians(1.0)
_DEPTH_BAND_M = 0.2


def course_metrics(recording: Recording, scenario: Scenario) -> dict[str, Any]:
    """
    Return the metrics of a run whose vehicles follow a course.

    Returns
    -------
    metrics : dict
        As `MEANINGS` describes them. Settling times are the first times after which the error stays within
        the band to the end of the run. Distances beside the path count after 150 s.

    """
    t_s, n = recording.t_s[:-1], recording.n_vehicles
    heading_err_rad, depth_err_m = heading_error_rad(recording), depth_error_m(recording)
    section = scenario.agent.course
    has_path = section is not None and make_course(section, scenario.period_s).reach(0.0) is not None
    beside_m = _column(recording, CROSS_TRACK)[after(t_s, GATHERED_AFTER_S)] if has_path else np.zeros((0, n))
    return {
        "heading_settling_1deg_s": _worst_settling_s(t_s, heading_err_rad, _HEADING_BAND_RAD),
        "heading_overshoot_rad": max(_overshoot(heading_err_rad[:, i]) for i in range(n)),
        "depth_settling_0p2m_s": _worst_settling_s(t_s, depth_err_m, _DEPTH_BAND_M),
        "depth_overshoot_m": max(_overshoot(depth_err_m[:, i]) for i in range(n)),
        "cross_track_rms_m": largest(np.array([rms(beside_m[:, i]) or np.nan for i in range(n)])),
        "cross_track_max_m": largest(np.abs(beside_m)),
    }


def heading_error_rad(recording: Recording) -> FloatArray:
    """Return the (K, N) commanded minus true headings (rad, in [-pi, pi])."""
    error: FloatArray = _column(recording, HEADING) - heading_rad(recording)[:-1]
    return np.remainder(error + np.pi, 2.0 * np.pi) - np.pi


def depth_error_m(recording: Recording) -> FloatArray:
    """Return the (K, N) commanded minus true depths (m)."""
    return _column(recording, DEPTH) - recording.position_ned_m[:-1, :, 2]


def _column(recording: Recording, column: int) -> FloatArray:
    """Return the (K, N) numbers of a column of the laws' states; NaN if it was not recorded."""
    if recording.law_state.shape[2] <= column:
        return np.full(recording.law_state.shape[:2], np.nan)
    return recording.law_state[..., column]


def _worst_settling_s(t_s: FloatArray, errors: FloatArray, band: float) -> float | None:
    """Return the first time after which no error leaves the band, None if the last one is outside."""
    is_outside: BoolArray = np.any(np.abs(errors) > band, axis=1)
    if not len(t_s) or is_outside[-1]:
        return None
    return float(t_s[is_outside.nonzero()[0][-1] + 1]) if is_outside.any() else float(t_s[0])


def _overshoot(errors: FloatArray) -> float:
    """Return the largest error of the other sign after the largest error."""
    known = errors[np.isfinite(errors)]
    if not known.size:
        return 0.0
    worst = int(np.abs(known).argmax())
    return float(np.max(-np.sign(known[worst]) * known[worst:], initial=0.0))
