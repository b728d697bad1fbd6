"""
Flights of six vehicles that switch their shape, or repair it after a loss.

The spacing is 10 m. A vehicle that fails at 60 s has no thrust from then on and glides; the others notice it
2 s later and move in 40 s.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from auv_control.formations.assignment import assigned_slots, least_separation_m
from auv_control.formations.references import Weights, reference_weights
from auv_control.formations.shapes import predecessors, shape_slots
from auv_experiment.metrics.finite import norm
from auv_experiment.metrics.formations.stability import least_distance_m, settled_after_s
from auv_thesis.formation.cases import SPACING_M, SPEED_MPS, TYPES
from auv_thesis.formation.law import Floats
from auv_thesis.formation.team import Flight, Force, Path, Plan, Setting, circle, fly, no_force, straight

COUNT, MOVE_S = 6, 60.0
SWITCHES = (
    ("column", "wedge"),
    ("column", "line"),
    ("double_platoon", "column"),
    ("double_platoon", "line"),
    ("line", "wedge"),
    ("wedge", "double_platoon"),
)
PATHS: dict[str, Path] = {"straight": straight(SPEED_MPS), "circle": circle(50.0, 0.01)}
START_S, IN_PLACE_M = 20.0, 0.1
FAILED, FAILS_AT_S, NOTICED_AFTER_S, REPAIR_S = 2, 60.0, 2.0, 40.0
WRECK_REACH_M, WRECK_GAIN, WRECK_SWIRL = 6.0, 1e4, 1.0
LIMIT_N = 800.0


class SwitchNumbers(NamedTuple):
    """Time until all are within 0.1 m of their new slot (s), least distance (m), largest force (N)."""

    switch_s: float
    separation_m: float
    force_n: float


class RepairNumbers(NamedTuple):
    """
    A repair.

    repair_s : float
        Time from the notice until all live vehicles are within 0.1 m of their new slot (s); inf: never.
    separation_m, wreck_m : float
        Least distance of two live vehicles, and of one to the lost one once it has glided out (m).
    away_m : float
        Largest distance of a live vehicle from its slot at the end (m).
    glide_m : float
        Distance that the lost vehicle glides (m).

    """

    repair_s: float
    separation_m: float
    wreck_m: float
    away_m: float
    glide_m: float


def _weights(name: str, shape: str, count: int) -> Weights:
    return reference_weights(TYPES[name], predecessors(shape_slots(shape, count, SPACING_M)))


def _slots(shape: str, count: int = COUNT) -> Floats:
    return np.array(shape_slots(shape, count, SPACING_M))


@cache
def switch_numbers(before: str, after: str, path: str) -> SwitchNumbers:
    """Return the numbers of a switch under the leader type."""
    start, slots = _slots(before), _slots(after)
    ends = slots[list(assigned_slots(start.tolist(), slots.tolist()))]
    weights = _weights("leader", before, COUNT)
    plan = Plan(start, ends, weights, START_S, MOVE_S)
    flight = fly(Setting((plan,), PATHS[path], START_S + 2.0 * MOVE_S))
    late = flight.t_s >= START_S
    # The path's frame at the end of the move, not the blend, is what "in place" means.
    turned_m = _away_from(flight, ends, path)
    return SwitchNumbers(
        settled_after_s(flight.t_s[late], turned_m[late], IN_PLACE_M) - START_S,
        least_distance_m(flight.positions),
        float(np.abs(flight.forces_n[late]).max()),
    )


def straight_separation_m(before: str, after: str) -> float:
    """Return the least distance on straight, synchronised ways (m)."""
    start, slots = _slots(before), _slots(after)
    ends = slots[list(assigned_slots(start.tolist(), slots.tolist()))]
    return least_separation_m(start.tolist(), ends.tolist())


def _away_from(flight: Flight, ends: Floats, path: str) -> Floats:
    """Return the distances of the vehicles from their final slots at each instant, (K, N) (m)."""
    away = []
    for t_s, positions in zip(flight.t_s.tolist(), flight.positions, strict=True):
        leg = PATHS[path](t_s)
        c, s = np.cos(leg.course.chi_rad), np.sin(leg.course.chi_rad)
        turn = np.array(((c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0)))
        away.append(norm(positions - leg.position - ends @ turn))
    return np.array(away)


def _around(wreck: int) -> Force:
    """Return the force with a swirl that leads vehicles around a lost one (N; NED)."""

    def force(t_s: float, eta: Floats, nu: Floats) -> Floats:
        pushes = np.zeros_like(eta)
        if t_s < FAILS_AT_S + NOTICED_AFTER_S:
            return pushes
        away = eta[:, :3] - eta[wreck, :3]
        range_m = np.maximum(norm(away), 1e-6)
        near = (range_m < WRECK_REACH_M) & (np.arange(len(eta)) != wreck)
        strength = WRECK_GAIN * (1.0 / range_m - 1.0 / WRECK_REACH_M) / range_m**2
        n = away / range_m[:, None]
        across = np.column_stack((-n[:, 1], n[:, 0], np.zeros(len(n))))
        pushes[near, :3] = (strength[:, None] * (n + WRECK_SWIRL * across))[near]
        return pushes

    return force


@cache
def repair_numbers(shape: str, name: str, *, repairs: bool, avoids: bool = False) -> RepairNumbers:
    """Return the numbers of a loss in a shape under a reference type, repaired or not."""
    start = _slots(shape)
    first = Plan(start, start, _weights(name, shape, COUNT))
    plans: tuple[Plan, ...] = (first,)
    live = [i for i in range(COUNT) if i != FAILED]
    ends = start
    if repairs:
        noticed_s = FAILS_AT_S + NOTICED_AFTER_S
        slots = _slots(shape, COUNT - 1)
        taken = assigned_slots(start[live].tolist(), slots.tolist())
        ends = start.copy()
        ends[live] = slots[list(taken)]
        smaller = reference_weights(
            TYPES[name], predecessors(shape_slots(shape, COUNT - 1, SPACING_M), taken[0])
        )
        others, path = np.zeros((COUNT, COUNT)), np.zeros(COUNT)
        others[np.ix_(live, live)] = smaller.others[np.ix_(taken, taken)]
        path[live] = smaller.path[list(taken)]
        path[FAILED] = 1.0
        plans = (first, Plan(start, ends, Weights(others, path), noticed_s, REPAIR_S))
    flight = fly(
        Setting(
            plans,
            PATHS["straight"],
            260.0,
            avoidance=_around(FAILED) if avoids else no_force,
            dead_from_s={FAILED: FAILS_AT_S},
            max_force_n=LIMIT_N,
        )
    )
    away_m = _away_from(flight, ends, "straight")[:, live]
    late = flight.t_s >= FAILS_AT_S + NOTICED_AFTER_S
    wreck = flight.positions[:, [FAILED]]
    failed_at = int(np.searchsorted(flight.t_s, FAILS_AT_S))
    return RepairNumbers(
        settled_after_s(flight.t_s[late], away_m[late], IN_PLACE_M) - FAILS_AT_S - NOTICED_AFTER_S,
        least_distance_m(flight.positions[:, live]),
        float(norm(flight.positions[late][:, live] - wreck[late]).min()),
        float(away_m[-1].max()),
        float(norm(wreck[-1, 0] - wreck[failed_at, 0])),
    )
