"""
A disturbance of the formation of chapter 3: what each reference type makes of a push on one vehicle.

Three vehicles fly abreast on circles of 10, 20 and 30 m, the inner one in the lead; "none" is the thesis's
own scheme, in which every vehicle follows its own path and hears of no other. A push of 60 N north and 60 N
east on one vehicle lasts 20 s.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from auv_control.formations.frame import Course
from auv_control.formations.references import Weights, reference_weights
from auv_control.formations.shapes import NO_SLOT
from auv_experiment.metrics.finite import norm
from auv_thesis.formation.cases import SPACING_M, TYPES, side_by_side
from auv_thesis.formation.law import Floats
from auv_thesis.formation.team import Leg, Plan
from auv_thesis.items import AGREES, AGREES_IN_PART, DIFFERS, Row, Run, Table

PUSH_N, PUSHED_FROM_S, PUSHED_FOR_S = 60.0, 100.0, 20.0
NONE = "none"
CASES = (NONE, "predecessor", "leader", "l-p 0.5/0.5", "neighbour")
_RADIUS_M, _RATE_RADPS, _DEPTH_M = 10.0, 0.01, 10.0
_TOLERANCE_M = 0.01
_EXPECTED_M = {
    (0, NONE): (0.778,),
    (0, "predecessor"): (0.073,),
    (0, "leader"): (0.073,),
    (0, "l-p 0.5/0.5"): (0.073,),
    (0, "neighbour"): (0.159,),
    (1, NONE): (0.738, 0.733),
    (1, "predecessor"): (0.739, 0.068),
}


class DisturbanceNumbers(NamedTuple):
    """Largest errors of d12 and d23, and largest distance of each vehicle from its own circle (m)."""

    distances_m: tuple[float, float]
    paths_m: tuple[float, float, float]


def _circle(t_s: float) -> Leg:
    """Return the inner circle of thesis Eq. (3.37) at a time; it turns left, so that +y points outwards."""
    angle = _RATE_RADPS * t_s
    c, s, speed = np.cos(angle), np.sin(angle), _RADIUS_M * _RATE_RADPS
    return Leg(
        np.array((_RADIUS_M * s, _RADIUS_M * c, _DEPTH_M)),
        np.array((speed * c, -speed * s, 0.0)),
        np.array((-speed * _RATE_RADPS * s, -speed * _RATE_RADPS * c, 0.0)),
        Course(-angle, -_RATE_RADPS),
    )


def _plan(name: str) -> Plan:
    offsets = np.array([(0.0, k * SPACING_M, 0.0) for k in range(3)])
    if name == NONE:
        return Plan(offsets, offsets, Weights(np.zeros((3, 3)), np.ones(3)))
    return Plan(offsets, offsets, reference_weights(TYPES[name], (NO_SLOT, 0, 1)))


@cache
def disturbances(pushed: int) -> dict[str, DisturbanceNumbers]:
    """Return the numbers of every type for a push on one vehicle."""

    def push(t_s: float, eta: Floats, nu: Floats) -> Floats:
        forces = np.zeros_like(eta)
        if PUSHED_FROM_S <= t_s < PUSHED_FROM_S + PUSHED_FOR_S:
            forces[pushed::3, :2] = PUSH_N
        return forces

    flights = side_by_side([_plan(name) for name in CASES], path=_circle, duration_s=160.0, force=push)
    found = {}
    for name, flight in zip(CASES, flights, strict=True):
        steps_m = np.abs(norm(np.diff(flight.positions, axis=1)) - SPACING_M).max(axis=0)
        away_m = norm(flight.positions - flight.offsets - flight.path[:, None]).max(axis=0)
        d12, d23 = steps_m.tolist()
        one, two, three = away_m.tolist()
        found[name] = DisturbanceNumbers((d12, d23), (one, two, three))
    return found


def _rows(runs: list[Run]) -> list[Row]:
    rows = []
    for (pushed, name), expected in _EXPECTED_M.items():
        ours = disturbances(pushed)[name]
        near = [abs(a - b) <= _TOLERANCE_M for a, b in zip(expected, ours.distances_m, strict=False)]
        what = "|d12 - 10|" if len(expected) == 1 else "|d12 - 10|, |d23 - 10|"
        rows.append(
            Row(
                f"push on AUV{pushed + 1}, {name}: largest {what} (m)",
                " ".join(f"{each:.3f}" for each in expected),
                " ".join(f"{each:.3f}" for each in ours.distances_m[: len(expected)]),
                AGREES if all(near) else AGREES_IN_PART if any(near) else DIFFERS,
                "off its own circle: " + ", ".join(f"{each:.2f}" for each in ours.paths_m) + " m",
            )
        )
    return rows


TABLES = (Table("1.J", "A push on one vehicle of the formation of chapter 3", (), _rows, "expected"),)
