"""Metrics of gathering: whether and when a flock formed, and the distances of all pairs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from auv_experiment.metrics.distances import (
    flock_pair_distances_m,
    pair_distances_m,
    pair_is_gone,
    touch_distances_m,
)
from auv_experiment.metrics.finite import largest, smallest
from auv_experiment.metrics.windows import (
    GATHERED_AFTER_S,
    LATE_AFTER_S,
    SETTLED_AFTER_S,
    TIME_TOLERANCE_S,
    after,
)
from auv_experiment.recording import BoolArray, FloatArray, Recording
from auv_flocking.flocking import LayeredParams

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


APPROACH_MEAN_AFTER_S = 20.0
APPROACH_BAND_RATIO = 0.02
FORMED_SPACINGS = 2.0
FORMED_FOR_S = 10.0


def approach_metrics(recording: Recording, scenario: Scenario) -> dict[str, Any]:
    """Return whether any two hulls touched, and the smallest distance of any two; see `MEANINGS`."""
    pairs_m = pair_distances_m(recording)
    ever_touching = (pairs_m < touch_distances_m(scenario)).any(axis=1)
    return {
        "collision": bool(ever_touching.any()),
        "collision_at_s": recording.t_s[ever_touching.argmax()] if ever_touching.any() else None,
        "pair_distance_min_m": smallest(pairs_m),
    }


def gathering_metrics(recording: Recording, scenario: Scenario) -> dict[str, Any]:
    """
    Return the metrics of the distances of all pairs of a flock.

    Parameters
    ----------
    recording : Recording
        The run.
    scenario : Scenario
        Its scenario: spacing of the flocking law.

    Returns
    -------
    metrics : dict
        As `MEANINGS` describes them; `formed_at_s` is NaN if the flock never formed.

    """
    t_s = recording.t_s
    flock_pairs_m = flock_pair_distances_m(recording)
    within_m = formed_within_m(scenario)
    formed_at_s = math.nan
    if within_m is not None:
        formed_at_s = _formed_at_s(t_s, flock_pairs_m < within_m, pair_is_gone(recording))
    formed_m = flock_pairs_m[t_s >= formed_at_s - TIME_TOLERANCE_S]
    settled_m = flock_pairs_m[after(t_s, SETTLED_AFTER_S)]
    return {
        "formed_at_s": formed_at_s,
        "pair_distance_formed_min_m": smallest(formed_m),
        "pair_distance_formed_max_m": largest(formed_m),
        "pair_distance_settled_min_m": smallest(settled_m),
        "pair_distance_settled_max_m": largest(settled_m),
        "pair_distance_min_after_150s_m": smallest(flock_pairs_m[after(t_s, GATHERED_AFTER_S)]),
        "pair_distance_max_after_200s_m": largest(flock_pairs_m[after(t_s, LATE_AFTER_S)]),
        "approach_time_2pct_s": _approach_time_s(t_s, flock_pairs_m),
    }


def formed_within_m(scenario: Scenario) -> float | None:
    """
    Return the distance within which every pair of a formed flock is (m), None without a flock.

    Without layers it is twice the law's ``spacing_m``, at which neighbours begin to repel, or twice
    ``formation_spacing_m`` of a law without it. With layers it is the diagonal with their ``height_m``.
    """
    if scenario.agent.flocking is None:
        return None
    params: Any = scenario.agent.flocking.params
    if hasattr(params, "extent_m"):  # a formation with slots
        return float(params.extent_m(len(scenario.vehicles)) + 0.5 * params.spacing_m)
    spacing_m = getattr(params, "spacing_m", None)
    level_m = FORMED_SPACINGS * (params.formation_spacing_m if spacing_m is None else spacing_m)
    height_m = params.height_m(len(scenario.vehicles)) if isinstance(params, LayeredParams) else 0.0
    return math.hypot(level_m, height_m)


def _formed_at_s(t_s: FloatArray, pair_is_near: BoolArray, is_gone: BoolArray) -> float:
    """Return the end of the first FORMED_FOR_S with all pairs near (s), NaN if there is none."""
    is_near = (pair_is_near | is_gone).all(axis=1) & ~is_gone.all(axis=1)
    last_far = np.maximum.accumulate(np.where(is_near, -1, np.arange(len(t_s))))
    near_since_s = t_s[np.minimum(last_far + 1, len(t_s) - 1)]
    is_formed = is_near & (t_s - near_since_s >= FORMED_FOR_S - TIME_TOLERANCE_S)
    return float(t_s[is_formed.argmax()]) if is_formed.any() else math.nan


def _approach_time_s(t_s: FloatArray, flock_pairs_m: FloatArray) -> float | None:
    """Return the first time after which every pair stays within 2 % of its own late mean (s)."""
    late_m = flock_pairs_m[after(t_s, APPROACH_MEAN_AFTER_S)]
    exists = np.isfinite(late_m)
    if not exists.any():
        return None
    count = exists.sum(axis=0)
    mean_m = np.where(exists, late_m, 0.0).sum(axis=0) / np.maximum(count, 1)
    with np.errstate(invalid="ignore"):
        is_far = np.abs(flock_pairs_m - mean_m) > APPROACH_BAND_RATIO * mean_m
    is_any_far = (is_far & (count > 0)).any(axis=1)
    if is_any_far[-1]:
        return None
    return float(t_s[len(t_s) - is_any_far[::-1].argmax()]) if is_any_far.any() else float(t_s[0])
