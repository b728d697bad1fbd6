"""
The flights behind the chapter on formations, and their numbers.

Teams of the same path fly side by side (`team.joined`). The column has 10 m between its vehicles; its path
goes north at 0.5 m/s and steps by 0.3 m/s at 20 s, and accelerations are not communicated, unless a function
says otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from auv_control.formations.references import Weights, reference_weights
from auv_control.formations.shapes import predecessors, shape_slots
from auv_experiment.metrics.finite import norm
from auv_experiment.metrics.formations.stability import (
    decay_rate_ps,
    gains_along_string,
    gains_over_layers,
    root_of_integral,
    spacing_errors_m,
    stacked_m,
    sup,
)
from auv_thesis.formation.law import Floats, Law
from auv_thesis.formation.team import STEP_S, Flight, Plan, Setting, fly, joined, straight

SPACING_M = 10.0
SPEED_MPS, STEP_MPS, STEP_AT_S = 0.5, 0.3, 20.0
TYPES: dict[str, Mapping[str, float]] = {
    "predecessor": {"predecessor": 1.0},
    "l-p 0.5/0.5": {"leader": 0.5, "predecessor": 0.5},
    "l-p 0.8/0.2": {"leader": 0.8, "predecessor": 0.2},
    "l-n": {"leader": 0.5, "neighbour": 0.5},
    "l-p-n": {"leader": 1 / 3, "predecessor": 1 / 3, "neighbour": 1 / 3},
    "p-n": {"predecessor": 0.5, "neighbour": 0.5},
    "neighbour": {"neighbour": 1.0},
    "leader": {"leader": 1.0},
}
FOUR_TYPES = ("predecessor", "leader", "l-p 0.5/0.5", "neighbour")
AMPLITUDES_MPS = (0.05, 0.1, 0.2, 0.4, 0.8)
MESH = 5


class StringNumbers(NamedTuple):
    """Largest spacing errors E_1 ... (m), and the largest gamma in the sup and in the L2 norm."""

    errors_m: list[float]
    gamma: float | None
    gamma_l2: float | None


class LeaderNumbers(NamedTuple):
    """
    Leader-to-formation stability of a type.

    gains : list of float
        g(a) = sup |z| / a of the stacked own-target errors, for `AMPLITUDES_MPS` (m per m/s).
    tail_m : float
        Largest |z| in the last 20 s (m).
    first_m, last_m : float
        Amplitude of the leader and of the last vehicle under 40 N with a period of 20 s (m).

    """

    gains: list[float]
    tail_m: float
    first_m: float
    last_m: float


def column(count: int, shares: Mapping[str, float]) -> Plan:
    """Return a column of vehicles with a reference type."""
    slots = shape_slots("column", count, SPACING_M)
    offsets = np.array(slots)
    return Plan(offsets, offsets, reference_weights(shares, predecessors(slots)))


def parts(plans: Sequence[Plan], flight: Flight) -> list[Flight]:
    """Return the flights of teams that flew side by side."""
    ends = np.cumsum([len(plan.before) for plan in plans])[:-1]
    fields = (flight.positions, flight.offsets, flight.wanted, flight.forces_n)
    cut = [np.split(each, ends, axis=1) for each in fields]
    return [
        Flight(flight.t_s, positions, offsets, wanted, flight.path, forces_n)
        for positions, offsets, wanted, forces_n in zip(*cut, strict=True)
    ]


def side_by_side(plans: Sequence[Plan], **conditions: object) -> list[Flight]:
    """Return the flights of teams along one path."""
    return parts(plans, fly(Setting((joined(plans),), **conditions)))  # type: ignore[arg-type]


def spacing(flight: Flight) -> Floats:
    """Return the spacing errors of a column (m), from the step of the path on."""
    followed = predecessors(shape_slots("column", flight.positions.shape[1], SPACING_M))
    errors = spacing_errors_m(flight.positions, flight.path, flight.offsets, followed)
    return errors[flight.t_s >= STEP_AT_S]


def string_numbers(flight: Flight) -> StringNumbers:
    """Return the numbers of a column."""
    errors = spacing(flight)
    followed = predecessors(shape_slots("column", errors.shape[1], SPACING_M))
    sizes = sup(errors)
    l2 = gains_along_string(root_of_integral(errors, STEP_S), followed)
    along = gains_along_string(sizes, followed)
    return StringNumbers(sizes[1:].tolist(), max(along, default=None), max(l2) if along else None)


@cache
def strings() -> dict[tuple[str, int], StringNumbers]:
    """Return the numbers of columns, by type and number of vehicles: each of 8, two of 4 and 12 as well."""
    cases = [
        *((name, 8) for name in TYPES),
        *((name, n) for name in ("neighbour", "predecessor") for n in (4, 12)),
    ]
    path = straight(SPEED_MPS, STEP_MPS, STEP_AT_S)
    flights = side_by_side([column(n, TYPES[name]) for name, n in cases], path=path, duration_s=100.0)
    return dict(zip(cases, map(string_numbers, flights), strict=True))


_PLACES = [(i, j) for i in range(MESH) for j in range(MESH)]
_AHEAD = [[_PLACES.index(place) for place in ((i - 1, j), (i, j - 1)) if min(place) >= 0] for i, j in _PLACES]
"""The vehicles that (i, j) follows in a mesh: (i - 1, j) and (i, j - 1)."""


def _mesh(leader_weight: float) -> Plan:
    """Return a mesh in which each vehicle steers by those that it follows and by the leader (0, 0)."""
    offsets = SPACING_M * np.array([(-i, j, 0.0) for i, j in _PLACES])
    others, path = np.zeros((len(_PLACES), len(_PLACES))), np.zeros(len(_PLACES))
    path[0] = 1.0
    for k, ahead in enumerate(_AHEAD[1:], start=1):
        others[k, ahead] += (1.0 - leader_weight) / len(ahead)
        others[k, 0] += leader_weight
    return Plan(offsets, offsets, Weights(others, path))


@cache
def meshes() -> dict[float, list[float]]:
    """Return the ratios of the errors of following layers i + j, by the weight of the leader."""
    path = straight(SPEED_MPS, STEP_MPS, STEP_AT_S)
    flights = side_by_side([_mesh(0.0), _mesh(0.5)], path=path, duration_s=60.0)
    return {
        weight: gains_over_layers(flight.positions - flight.offsets, _AHEAD)
        for weight, flight in zip((0.0, 0.5), flights, strict=True)
    }


@cache
def leader_numbers() -> dict[str, LeaderNumbers]:
    """Return leader-to-formation stability of six vehicles, by type."""
    plans = [column(6, TYPES[name]) for name in FOUR_TYPES]
    gains: dict[str, list[float]] = {name: [] for name in FOUR_TYPES}
    tails: dict[str, float] = dict.fromkeys(FOUR_TYPES, 0.0)
    for a_mps in AMPLITUDES_MPS:
        flights = side_by_side(plans, path=straight(SPEED_MPS, a_mps, STEP_AT_S), duration_s=120.0)
        for name, flight in zip(FOUR_TYPES, flights, strict=True):
            z_m = stacked_m(flight.positions - flight.wanted)
            gains[name].append(float(z_m.max() / a_mps))
            tails[name] = max(tails[name], float(z_m[flight.t_s > 100.0].max()))

    def surge(t_s: float, eta: Floats, nu: Floats) -> Floats:
        force = np.zeros_like(eta)
        force[::6, 0] = 40.0 * np.sin(2.0 * np.pi * t_s / 20.0)
        return force

    shaken = side_by_side(plans, path=straight(SPEED_MPS), duration_s=160.0, force=surge)
    numbers = {}
    for name, flight in zip(FOUR_TYPES, shaken, strict=True):
        north_m = (flight.positions - flight.offsets - flight.path[:, None])[flight.t_s > 80.0, :, 0]
        amplitude_m = 0.5 * (north_m.max(axis=0) - north_m.min(axis=0))
        numbers[name] = LeaderNumbers(gains[name], tails[name], float(amplitude_m[0]), float(amplitude_m[-1]))
    return numbers


@cache
def decay_rates_ps() -> dict[tuple[str, int], tuple[float, float]]:
    """
    Return the rate at which initial offsets of 1 m decay (1/s), fitted over 5 to 40 s, and the overshoot.

    The directions of the offsets are drawn once; the leader starts in its place.
    """
    cases = [(name, count) for name in FOUR_TYPES for count in (4, 8)]
    plans = [column(count, TYPES[name]) for name, count in cases]
    rng = np.random.default_rng(1)
    starts = []
    for _, count in cases:
        start = rng.normal(size=(count, 3))
        start /= norm(start)[:, None]
        start[0] = 0.0
        starts.append(start)
    flights = side_by_side(plans, path=straight(SPEED_MPS), duration_s=40.0, start_m=np.concatenate(starts))
    found = {}
    for case, flight in zip(cases, flights, strict=True):
        x_m = norm(norm(flight.positions - flight.offsets - flight.path[:, None]))
        late = flight.t_s >= 5.0
        rate_ps = decay_rate_ps(flight.t_s[late], x_m[late])
        found[case] = rate_ps, float(x_m.max() / x_m[0])
    return found


class AdaptationNumbers(NamedTuple):
    """Spacing errors of a column of 8 with wrong parameters (m): at the end, and the largest."""

    final_m: list[float]
    largest_m: list[float]


@cache
def adaptations() -> dict[bool, AdaptationNumbers]:
    """Return the errors of a predecessor column whose law has 0.7 of all parameters, without and with GAM."""
    path, plan = straight(SPEED_MPS, STEP_MPS, STEP_AT_S), column(8, TYPES["predecessor"])
    found = {}
    for adapts in (False, True):
        law = Law(initial_ratio=0.7, adapts=adapts)
        errors = spacing(fly(Setting((plan,), path, 200.0, law=law)))
        found[adapts] = AdaptationNumbers(errors[-1].tolist(), sup(errors).tolist())
    return found


@cache
def told_accelerations_m() -> list[float]:
    """Return the largest spacing errors of a predecessor column that is told accelerations (m)."""
    path, plan = straight(SPEED_MPS, STEP_MPS, STEP_AT_S), column(8, TYPES["predecessor"])
    return sup(spacing(fly(Setting((plan,), path, 60.0, tells_acceleration=True)))).tolist()
