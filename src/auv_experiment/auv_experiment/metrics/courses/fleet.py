"""
Metrics of a run whose vehicles are a fleet of lanes: coordination, distance beside the lane, packets.

They count from the time of formation on, when all working vehicles are in formation: those that are not lost,
and whose computers have not failed. A vehicle counts until then.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from auv_control.formations.shapes import predecessors
from auv_control.guidance.paths import make_path
from auv_core.geometry import Vec3
from auv_experiment.metrics.distances import is_working, pair_distances_m, working_distances
from auv_experiment.metrics.finite import finite, largest, rms, smallest
from auv_experiment.metrics.formations.gains import gain_metrics
from auv_experiment.metrics.windows import COORDINATED_AFTER_S, after
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
    params = scenario.agent.fleet.params
    track = make_path(params.path).track
    works = is_working(recording, scenario)
    t_s, works_at_tick, states = recording.t_s[:-1], works[:-1], recording.law_state
    modes = states[..., MODE]
    is_formed = ((modes == Mode.FORM) | ~works_at_tick).all(axis=1) & works_at_tick.any(axis=1)
    formed_at_s = float(t_s[is_formed.argmax()]) if is_formed.any() else None
    is_late: BoolArray = t_s >= (np.inf if formed_at_s is None else formed_at_s)
    beside_m = np.where(works_at_tick, states[..., CROSS_TRACK], np.nan)[is_late]
    errors_m = coordination_error_m(np.where(works_at_tick, states[..., GAMMA], np.nan), track.round_m)
    turns = (states[..., TURN_AWAY_COURSE] != STRAIGHT_ON)[(modes == Mode.TRANSIT) & works_at_tick]
    slots = params.slots(recording.n_vehicles) if works.all() else ()
    return {
        "fleet_formed_at_s": formed_at_s,
        "coordination_error_p95_m": _p95(errors_m[is_late]),
        "coordination_error_after_700s_p95_m": _p95(errors_m[after(t_s, COORDINATED_AFTER_S)]),
        "cross_track_rms_m": largest(np.array([rms(row) or np.nan for row in beside_m.T])),
        "cross_track_max_m": largest(np.abs(beside_m)),
        "packets_per_minute": _packets_per_minute(recording, scenario.period_s, formed_at_s),
        "packets_per_minute_after_700s": _packets_per_minute(
            recording, scenario.period_s, COORDINATED_AFTER_S
        ),
        "turn_away_ratio": float(turns.mean()) if turns.size else None,
        **_gain_metrics(states[is_late][..., GAMMA], track.round_m, slots, scenario.period_s),
        **working_distances(recording, works),
        **_formed_distances(recording, works, formed_at_s),
    }


def _formed_distances(
    recording: Recording, works: BoolArray, formed_at_s: float | None
) -> dict[str, float | None]:
    """Return the smallest and the largest distance of two working vehicles from formation on."""
    first, second = np.triu_indices(recording.n_vehicles, 1)
    both = works[:, first] & works[:, second]
    formed = np.s_[:0] if formed_at_s is None else recording.t_s >= formed_at_s
    formed_m = np.where(both, pair_distances_m(recording), np.nan)[formed]
    return {
        "pair_distance_formed_min_m": smallest(formed_m),
        "pair_distance_formed_max_m": largest(formed_m),
    }


def _p95(values: FloatArray) -> float | None:
    known = finite(values)
    return float(np.quantile(known, 0.95)) if known.size else None


def _gain_metrics(
    gammas_m: FloatArray, round_m: float, slots: tuple[Vec3, ...], period_s: float
) -> dict[str, Any]:
    """Return the gains of the errors along the path, of a fleet that has lost no vehicle."""
    apart_m = _within_a_round(gammas_m - gammas_m[:, :1], round_m)
    along = apart_m[..., np.newaxis] if slots else np.empty((0, 0, 1))
    return gain_metrics(along, np.zeros((len(along), 1)), np.zeros_like(along), predecessors(slots), period_s)


def coordination_error_m(gammas_m: FloatArray, round_m: float) -> FloatArray:
    """
    Return the largest difference of two path parameters at each tick (m), from their (K, N) values.

    A round of a closed path has `round_m` (m; 0: it is open). NaN counts for nothing.
    """
    apart_m = _within_a_round(gammas_m[:, :, np.newaxis] - gammas_m[:, np.newaxis, :], round_m)
    error_m: FloatArray = np.nanmax(np.abs(apart_m), axis=(1, 2), initial=0.0)
    return error_m


def _within_a_round(apart_m: FloatArray, round_m: float) -> FloatArray:
    """Return differences of path parameters without whole rounds (m); 0: the path is open."""
    return apart_m - round_m * np.round(apart_m / round_m) if round_m > 0.0 else apart_m


def _packets_per_minute(recording: Recording, period_s: float, from_s: float | None) -> float | None:
    """Return the packets of the whole fleet per minute from a time on (s)."""
    end_s = float(recording.t_s[-1])
    if from_s is None or end_s <= from_s:
        return None
    count = int((recording.sent[:, 0] * period_s >= from_s).sum())
    return 60.0 * count / (end_s - from_s)
