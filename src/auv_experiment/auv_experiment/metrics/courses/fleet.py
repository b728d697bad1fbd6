"""
Metrics of a run whose vehicles are a fleet of lanes: coordination, distance beside the lane, packets.

They count from the time of formation on, when all vehicles that are not lost are in formation.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from auv_control.guidance.paths import make_path
from auv_experiment.metrics.finite import largest, rms
from auv_experiment.recording import BoolArray, FloatArray, Recording
from auv_flocking.course_task import CROSS_TRACK
from auv_flocking.fleets.lanes import GAMMA, MODE, TURN_AWAY_COURSE
from auv_flocking.lanes.status import STRAIGHT_ON, Mode

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


def fleet_metrics(recording: Recording, scenario: Scenario) -> dict[str, Any]:
    """
    Return the metrics of a run whose vehicles are a fleet of lanes.

    Returns
    -------
    metrics : dict
        As `MEANINGS` describes them; None if the fleet never forms.

    """
    assert scenario.agent.fleet is not None
    track = make_path(scenario.agent.fleet.params.path).track
    is_live = np.isnan(recording.lost_at_s)
    states = recording.law_state[:, is_live]
    t_s, modes = recording.t_s[:-1], states[..., MODE]
    is_formed = (modes == Mode.FORM).all(axis=1)
    formed_at_s = float(t_s[is_formed.argmax()]) if is_formed.any() else None
    late: BoolArray = t_s >= (np.inf if formed_at_s is None else formed_at_s)
    beside_m = states[late][..., CROSS_TRACK]
    errors_m = coordination_error_m(states[late][..., GAMMA], track.length_m if track.is_closed else 0.0)
    turns = (states[..., TURN_AWAY_COURSE] != STRAIGHT_ON)[modes == Mode.TRANSIT]
    return {
        "fleet_formed_at_s": formed_at_s,
        "coordination_error_p95_m": float(np.quantile(errors_m, 0.95)) if errors_m.size else None,
        "cross_track_rms_m": largest(np.array([rms(row) or np.nan for row in beside_m.T])),
        "cross_track_max_m": largest(np.abs(beside_m)),
        "packets_per_minute": _packets_per_minute(recording, scenario.period_s, formed_at_s),
        "turn_away_ratio": float(turns.mean()) if turns.size else None,
    }


def coordination_error_m(gammas_m: FloatArray, round_m: float) -> FloatArray:
    """
    Return the largest difference of two path parameters at each tick (m), from their (K, N) values.

    A round of a closed path has `round_m` (m; 0: it is open).
    """
    apart_m = gammas_m[:, :, np.newaxis] - gammas_m[:, np.newaxis, :]
    if round_m > 0.0:
        apart_m -= round_m * np.round(apart_m / round_m)
    error_m: FloatArray = np.abs(apart_m).max(axis=(1, 2))
    return error_m


def _packets_per_minute(recording: Recording, period_s: float, formed_at_s: float | None) -> float | None:
    """Return the packets of the whole fleet per minute from the time of formation on."""
    end_s = float(recording.t_s[-1])
    if formed_at_s is None or end_s <= formed_at_s:
        return None
    count = int((recording.sent[:, 0] * period_s >= formed_at_s).sum())
    return 60.0 * count / (end_s - formed_at_s)
