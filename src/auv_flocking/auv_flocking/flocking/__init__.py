"""
Flocking laws: from what a vehicle knows to the velocity that it asks of itself.

To add one, write one file with ``Params``, which are `FlockingParams`, and ``Flocking(params, separation,
is_leader)``, a `FlockingLaw`.  The file's name is its ``kind``.  `flock_velocity` and `velocity` change
nothing, so that the sampled agent and the continuous-time runner use the same law.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, Protocol

from auv_control.references import PathPoint
from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Vec3
from auv_core.params import Section
from auv_flocking.neighbours.estimates import Neighbours
from auv_flocking.separation import SeparationLaw


class FlockVelocity(NamedTuple):
    """
    A belief of the flock's velocity (m/s; NED), and when a leader made it (s).

    It is passed on from vehicle to vehicle with its stamp; nobody's is stamped -inf.
    """

    velocity: Vec3
    stamp_s: float


NOTHING_HEARD = FlockVelocity((0.0, 0.0, 0.0), -math.inf)


class View(NamedTuple):
    """
    What one vehicle knows at one instant; positions in m, velocities in m/s, all NED.

    `neighbours` are the positions of `estimates`, in the same order; in continuous time, where everybody
    knows everything, there are no estimates.
    """

    position: Vec3
    centre: Vec3
    flock_velocity: Vec3
    neighbours: Sequence[Vec3]
    obstacles: tuple[tuple[Vec3, float], ...]
    path: PathPoint
    estimates: Neighbours = ()


class FlockingParams(Protocol):
    """What a scenario must know of a law, so that reports and actuators that cannot follow are refused."""

    @property
    def formation_spacing_m(self) -> float:
        """Largest distance that the law keeps between neighbours (m)."""

    @property
    def largest_correction_mps(self) -> float:
        """Most that the law adds to the velocity of the path (m/s; inf for no limit)."""

    @property
    def uses_flock_velocity(self) -> bool:
        """Whether `velocity` looks at the flock's velocity or at estimates: packets, not continuous time."""


class FlockingLaw(Protocol):
    """From what a vehicle knows to the velocity that it asks of itself."""

    def hear(self, estimates: Neighbours, dt_s: float) -> None:
        """Measure how old the information is; called first of all, once per control period of `dt_s`."""

    def flock_velocity(
        self, t_s: float, path: PathPoint, centre: Vec3, own: FlockVelocity, estimates: Neighbours
    ) -> FlockVelocity:
        """
        Return what this vehicle takes for the flock's velocity.

        It follows from the path point (leaders use it, blind followers must not), the own estimate of the
        centre, the own latest value and those in the neighbours' estimates.
        """

    def velocity(self, view: View) -> Vec3:
        """Return the velocity over ground that the law asks for (m/s; NED)."""

    def adapt(self, view: View, dt_s: float) -> None:
        """Let a separation law learn; called after `velocity`, once per control period of `dt_s`."""


def make_flocking(section: Section, separation: SeparationLaw, *, is_leader: bool) -> FlockingLaw:
    """Return the law of a section for a leader or a follower."""
    made = class_of(__name__, section.kind, "Flocking")(section.params, separation, is_leader)
    law: FlockingLaw = fulfilled(made, FlockingLaw)
    return law


def flocking_params(section: Section) -> FlockingParams:
    """Return the parameters of a section as what every law has."""
    params: FlockingParams = fulfilled(section.params, FlockingParams)
    return params
