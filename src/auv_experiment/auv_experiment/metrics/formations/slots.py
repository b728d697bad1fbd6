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
from auv_control.formations.shapes import NO_SHAPE, NO_SLOT, predecessors
from auv_experiment.metrics.distances import is_working, path_ned_m, working_distances
from auv_experiment.metrics.finite import norm, rms
from auv_experiment.metrics.formations.gains import gain_metrics
from auv_experiment.metrics.formations.stability import (
    FLOOR_M,
    LEADER,
    settled_after_s,
    stacked_m,
    target_errors,
)
from auv_experiment.recording import BoolArray, FloatArray, Recording
from auv_flocking.flocking import Member
from auv_flocking.flocking._formation import FormationParams, roster_of

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
    slots : tuple of N float
        The slot of each vehicle in the last formation, `NO_SLOT` for lost ones.
    others : (N, N) array
        Weight of each vehicle in the reference of another in the last formation, 0 for lost ones.
    changed_at_s : float
        When the last change began (s); 0 without a change.

    """

    offsets: FloatArray
    leaders: Any
    followed: tuple[int, ...]
    slots: tuple[float, ...]
    others: FloatArray
    changed_at_s: float


def formation_slot_metrics(recording: Recording, scenario: Scenario, formed_at_s: float) -> dict[str, Any]:
    """
    Return the metrics of a formation with slots, `{}` for other runs.

    `formation_error_rms_m` and the gains count from `formed_at_s` on; a formation that changes has no gain.
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
    counts = (t_s >= formed_at_s) & (plan.changed_at_s == 0.0) & np.isfinite(errors).all(axis=(1, 2))
    path = path_ned_m(recording, scenario)
    return {
        "formation_error_rms_m": rms(error_m[t_s >= formed_at_s]),
        "formation_error_final_m": float(off_m[-1][live].max()),
        "formation_in_place_after_s": max(0.0, settled_s),
        "formation_agreed_after_s": _agreed_after_s(recording, plan, live),
        **working_distances(recording, is_working(recording, scenario)),
        **gain_metrics(
            recording.position_ned_m[counts],
            path[counts],
            plan.offsets[counts],
            plan.followed,
            scenario.period_s,
        ),
        "leader_to_formation_gain_s": _gain_from_leader_s(
            errors[counts], path[counts], plan, scenario.period_s
        ),
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
    slots = tuple(float(order.slots.get(i + 1, NO_SLOT)) for i in range(count))
    others = np.zeros((count, count))
    members = [address - 1 for address in order.slots]
    places = list(order.slots.values())
    others[np.ix_(members, members)] = order.weights.others[np.ix_(places, places)]
    return Plan(offsets, leaders, followed, slots, others, changed_at_s)


def _agreed_after_s(recording: Recording, plan: Plan, live: BoolArray) -> float | None:
    """Return the time after which all live vehicles hold the slots of the last formation (s)."""
    held = recording.law_state[:, live]
    if held.shape[2] != recording.n_vehicles:
        return None
    is_other = (held != np.array(plan.slots)).any(axis=(1, 2))
    return max(0.0, settled_after_s(recording.t_s[:-1], is_other.astype(np.float64), 0.0))


def _gain_from_leader_s(errors: FloatArray, path: FloatArray, plan: Plan, step_s: float) -> float | None:
    """Return the largest |z| per change of the path's speed (m per m/s), None on a path of one speed."""
    if len(path) < 2 or LEADER not in plan.followed:
        return None
    speed_mps = norm(np.diff(path, axis=0)) / step_s
    change_mps = float(speed_mps.max() - speed_mps.min())
    if change_mps < FLOOR_M:
        return None
    z_m = stacked_m(target_errors(errors, plan.others), plan.followed.index(LEADER))
    return float(z_m.max()) / change_mps
