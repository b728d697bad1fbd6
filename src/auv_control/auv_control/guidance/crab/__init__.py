"""
Crab angle in guidance by line of sight: how the heading allows for current and sideslip.

To add one, write one file with ``Params`` and ``Crab(params, period_s)``, a `CrabLaw`. The file's name is its
``kind``.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

from auv_core.contracts import class_of, fulfilled
from auv_core.integrate import State
from auv_core.params import Section


class CrabView(NamedTuple):
    """
    What a crab law knows of one instant.

    The cross-track error y_e (m, positive to starboard of the path), and the course over ground minus the
    course of the path and minus the heading (rad; in [-pi, pi)).
    """

    cross_track_m: float
    course_error_rad: float
    drift_rad: float


class CrabLaw(Protocol):
    """
    The crab angle beta of a vehicle: psi_ref = chi - atan(y_e / Delta) - beta.

    `lookahead_m` is Delta, which belongs to the law: one that learns the crab angle slowly needs a longer
    one.
    """

    lookahead_m: float

    def initial_state(self, view: CrabView) -> State:
        """Return the state at the start, `()` for a law without state."""

    def step(self, state: State, view: CrabView) -> tuple[float, State]:
        """Return the crab angle (rad) of a control period, and the state after it."""


def make_crab(section: Section, period_s: float) -> CrabLaw:
    """Return the law of a section, for a control period (s)."""
    law: CrabLaw = fulfilled(class_of(__name__, section.kind, "Crab")(section.params, period_s), CrabLaw)
    return law
