"""
Metrics of a formation with slots: its error, and whether errors grow along its strings.

They compare the true motion with the plan that a fleet with perfect information would have: a vehicle that
fails is noticed `lost_after_s` later, the shape switches at its time, and the course is that of the path.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from auv_control.formations.frame import course_of, world_offset
from auv_control.formations.shapes import predecessors
from auv_experiment.metrics.finite import norm, rms
from auv_experiment.metrics.formations.stability import LEADER, gains_along_string, settled_after_s, sup
from auv_experiment.recording import FloatArray, Recording
from auv_flocking.flocking import Member
from auv_flocking.flocking._formation import NO_SHAPE, FormationParams, roster_of

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

IN_PLACE_M = 0.5


class Plan(NamedTuple):
    """
    The formation that a fleet should have.

    offsets : (K + 1, N, 3) array
        World offsets of the vehicles' slots (m; NED); NaN from a vehicle's failure on.
    leaders : (K + 1,) array of int
        Index of the leader; after its failure of the next one.
    followed : tuple of N int
        The vehicle that each one follows in the last formation, `LEADER` for the leader and for lost ones.
    changed_at_s : float
        When the last change began (s); 0 without a change.

    """

    offsets: FloatArray
    leaders: Any
    followed: tuple[int, ...]
    changed_at_s: float


def formation_slot_metrics(recording: Recording, scenario: Scenario, formed_at_s: float) -> dict[str, Any]:
    """
    Return the metrics of a formation with slots, `{}` for other runs.

    `formation_error_rms_m` and `string_gain_max` count from `formed_at_s` on; a formation that changes has no
    gain.
    """
    params = None if scenario.agent.flocking is None else scenario.agent.flocking.params
    if not isinstance(params, FormationParams) or recording.n_ticks == 0:
        return {}
    t_s, plan = recording.t_s, plan_of(recording, scenario, params)
    errors = recording.position_ned_m - plan.offsets
    rows = np.arange(len(t_s))
    off_m = norm(errors - errors[rows, plan.leaders][:, None])
    error_m = np.sqrt(np.nanmean(np.square(off_m), axis=1))
    live = np.isfinite(off_m[-1])
    settled_s = settled_after_s(t_s, off_m[:, live], IN_PLACE_M)
    counts = (t_s >= formed_at_s) & (plan.changed_at_s == 0.0)
    return {
        "formation_error_rms_m": rms(error_m[t_s >= formed_at_s]),
        "formation_error_final_m": float(off_m[-1][live].max()),
        "formation_in_place_after_s": max(0.0, settled_s),
        "string_gain_max": _string_gain(errors[counts], plan.followed),
    }


def plan_of(recording: Recording, scenario: Scenario, params: FormationParams) -> Plan:
    """Return the formation that the fleet of a run should have at each instant."""
    t_s, count = recording.t_s.tolist(), recording.n_vehicles
    roster = roster_of(params, Member(False, 0, count))
    fails_at_s = [math.inf if v.fails_at_s is None else v.fails_at_s for v in scenario.vehicles]
    path = scenario.reference_of()
    is_switched, changed_at_s = params.next_shape == NO_SHAPE, 0.0
    offsets = np.full((len(t_s), count, 3), math.nan)
    leaders = np.zeros(len(t_s), dtype=int)
    for row, now_s in enumerate(t_s):
        if not is_switched and now_s >= params.switch_at_s:
            is_switched, changed_at_s = True, now_s
            roster.switch(params.next_slots, now_s)
        live = tuple(i + 1 for i in range(count) if now_s < fails_at_s[i] + params.lost_after_s)
        if live != roster.live and live:
            changed_at_s = now_s
            roster.count_on(live, now_s)
        course = course_of(path.at(now_s)) if path is not None else None
        working = [address for address in roster.live if now_s < fails_at_s[address - 1]]
        leaders[row] = min(working, default=roster.order.leader) - 1
        for address in working:
            if course is not None:
                offsets[row, address - 1] = world_offset(roster.offset(address, now_s), course).position
    order = roster.order
    by_slot = {slot: address - 1 for address, slot in order.slots.items()}
    shape = params.shape if params.next_shape == NO_SHAPE or not is_switched else params.next_shape
    ahead = predecessors(params.slots(shape, len(order.slots)), order.slots[order.leader])
    followed = tuple(
        by_slot[ahead[order.slots[i + 1]]] if i + 1 in order.slots and i + 1 != order.leader else LEADER
        for i in range(count)
    )
    return Plan(offsets, leaders, followed, changed_at_s)


def _string_gain(errors: FloatArray, followed: tuple[int, ...]) -> float | None:
    """Return the largest ratio of the spacing error of a vehicle to that of the one that it follows."""
    if not len(errors):
        return None
    own = [
        np.zeros(len(errors)) if j == LEADER else norm(errors[:, i] - errors[:, j])
        for i, j in enumerate(followed)
    ]
    sizes = sup(np.nan_to_num(np.column_stack(own)))
    return max(gains_along_string(sizes, followed), default=None)
