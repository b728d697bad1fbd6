"""
Coordination along a path: the speed correction that brings the path parameters of a fleet together.

gamma_i is a vehicle's path parameter minus the offset of its slot along the path. Every vehicle flies its
lane at (1 - kappa o_y)(v_L + v_c), and a law gives v_c, limited to `correction_max_mps`.

To add one, write one file with ``Params``, which are `CoordinationParams`, and ``Coordination(params,
pace)``, a `CoordinationLaw`. The file's name is its ``kind``. A law is pure: the caller keeps its state, a
tuple of floats.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from auv_core.contracts import class_of, fulfilled
from auv_core.integrate import State
from auv_core.params import Section
from auv_flocking.lanes.status import LaneNeighbour, LaneStatus


class Pace(NamedTuple):
    """What all vehicles share: speed v_L along the path (m/s), length of a round (m; 0: open), period (s)."""

    speed_mps: float
    round_m: float
    period_s: float


class LanePlace(NamedTuple):
    """The own path parameter gamma (m) at a time (s), and whether the vehicle cannot keep up."""

    t_s: float
    gamma_m: float
    is_limited: bool = False


class CoordinationParams(Protocol):
    """Properties of a law for the checks of a scenario."""

    @property
    def correction_max_mps(self) -> float:
        """Largest correction of the speed along the path (m/s)."""


class CoordinationLaw(Protocol):
    """Gives the speed correction of a vehicle."""

    def begin(self, own: LanePlace) -> State:
        """Return the state when the vehicle comes into its lane, `()` for a law without state."""

    def hear(self, state: State, own: LanePlace, other: LaneNeighbour) -> State:
        """Return the state after a new packet of a neighbour in its lane."""

    def step(self, state: State, own: LanePlace, others: Sequence[LaneNeighbour]) -> tuple[float, State]:
        """
        Return the speed correction v_c (m/s) of a control period, and the state after it.

        `others` are the neighbours in their lanes, as their newest packets tell.
        """

    def reference_m(self, state: State, own: LanePlace) -> float:
        """Return the reference r for the own packets (m)."""

    def predicted_m(self, sent: LaneStatus, sent_s: float, t_s: float) -> float:
        """Return gamma (m) as receivers predict it from a packet with a time tag (s)."""


def make_coordination(section: Section, pace: Pace) -> CoordinationLaw:
    """Return the law of a section for a fleet of one pace."""
    made = class_of(__name__, section.kind, "Coordination")(section.params, pace)
    law: CoordinationLaw = fulfilled(made, CoordinationLaw)
    return law
