"""
Separation laws: they keep two vehicles, or a vehicle and an obstacle, apart.

To add one, write one file with ``Params`` and ``Separation(params)``, a `SeparationLaw`.  The file's name is
its ``kind``.  A law may have further protocols:

* an `ObstacleLaw`, if obstacles are not treated like vehicles;
* a `PotentialLaw`: the metrics of a run then tell whether the flock's potential decreases;
* a `LearningLaw`, which has a state and is refused in continuous time, and of these an
  `ObstacleLearningLaw`, which learns from obstacles too;
* a `CentralLaw`, which acts along the line between the two: it is then compiled with the loop over all
  pairs of a flock.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, runtime_checkable

from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Vec3
from auv_core.params import Section
from auv_flocking.central import Numbers, Strength


class SeparationLaw(Protocol):
    """Keeps two vehicles apart."""

    def velocity(self, own: Vec3, other: Vec3, spacing_m: float) -> Vec3:
        """Return the velocity (m/s; NED, for unit gain) of the vehicle at `own` because of `other`."""


@runtime_checkable
class ObstacleLaw(SeparationLaw, Protocol):
    """A law that treats obstacles differently from vehicles."""

    def obstacle_velocity(self, own: Vec3, obstacle: Vec3, spacing_m: float) -> Vec3:
        """Return the velocity (m/s; NED, for unit gain) of the vehicle at `own` because of an obstacle."""


@runtime_checkable
class PotentialLaw(SeparationLaw, Protocol):
    """A law whose velocities are the negative gradient of a potential."""

    def potential(self, distance_m: float, spacing_m: float) -> float:
        """Return the potential of a pair of vehicles (m^2/s)."""

    def obstacle_potential(self, distance_m: float, spacing_m: float) -> float:
        """Return the potential of a vehicle and an obstacle (m^2/s)."""


@runtime_checkable
class LearningLaw(SeparationLaw, Protocol):
    """A law with a state."""

    def adapt(self, distances_m: Sequence[float], spacing_m: float, dt_s: float) -> None:
        """Adapt to the distances to the neighbours; called once per control period of `dt_s`."""


@runtime_checkable
class ObstacleLearningLaw(LearningLaw, Protocol):
    """A law that also learns from its distances to obstacles."""

    def adapt_to_obstacles(self, errors_m: Sequence[float], dt_s: float) -> None:
        """
        Adapt to the distances to the obstacles, each minus the safety distance of that obstacle (m); called
        once per control period of `dt_s`, with no errors if there are no obstacles.
        """


@runtime_checkable
class CentralLaw(SeparationLaw, Protocol):
    """
    A law that acts along the line between the two; see `auv_flocking.central`.

    `strength` with `numbers` is `velocity`, `obstacle_strength` with `obstacle_numbers` is the effect of
    obstacles.
    """

    strength: Strength
    numbers: Numbers
    obstacle_strength: Strength
    obstacle_numbers: Numbers

    def reach_m(self, spacing_m: float) -> float:
        """Return the distance at and beyond which two vehicles do not interact (m; inf: none)."""


def make_separation(section: Section) -> SeparationLaw:
    """Return the separation law of a section."""
    made = class_of(__name__, section.kind, "Separation")(section.params)
    law: SeparationLaw = fulfilled(made, SeparationLaw)
    return law


def obstacle_velocity_of(law: SeparationLaw) -> Callable[[Vec3, Vec3, float], Vec3]:
    """Return the function of an `ObstacleLaw`, or that for vehicles if obstacles are treated alike."""
    return law.obstacle_velocity if isinstance(law, ObstacleLaw) else law.velocity
