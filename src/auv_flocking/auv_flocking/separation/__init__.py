"""
Separation laws: what keeps two vehicles, or a vehicle and an obstacle, apart.

To add one, write one file with ``Params`` and ``Separation(params)``, a `SeparationLaw`.  The file's name is
its ``kind``.  A law may be more than that:

* an `ObstacleLaw`, where obstacles are not treated as vehicles are;
* a `PotentialLaw`: runs then say whether the flock's potential falls;
* a `LearningLaw`, which has a memory and is refused in continuous time;
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
    """What keeps two vehicles apart."""

    def velocity(self, own: Vec3, other: Vec3, spacing_m: float) -> Vec3:
        """Return the velocity (m/s; NED, for unit gain) of the vehicle at `own` because of `other`."""


@runtime_checkable
class ObstacleLaw(SeparationLaw, Protocol):
    """A law that treats obstacles in another way than vehicles."""

    def obstacle_velocity(self, own: Vec3, obstacle: Vec3, spacing_m: float) -> Vec3:
        """Return the velocity (m/s; NED, for unit gain) of the vehicle at `own` because of an obstacle."""


@runtime_checkable
class PotentialLaw(SeparationLaw, Protocol):
    """A law whose velocities are the fall of a potential."""

    def potential(self, distance_m: float, spacing_m: float) -> float:
        """Return the potential of a pair of vehicles (m^2/s)."""

    def obstacle_potential(self, distance_m: float, spacing_m: float) -> float:
        """Return the potential of a vehicle and an obstacle (m^2/s)."""


@runtime_checkable
class LearningLaw(SeparationLaw, Protocol):
    """A law with a memory."""

    def adapt(self, distances_m: Sequence[float], spacing_m: float, dt_s: float) -> None:
        """Learn from the distances to the neighbours; called once per control period of `dt_s`."""


@runtime_checkable
class CentralLaw(SeparationLaw, Protocol):
    """
    A law that acts along the line between the two; see `auv_flocking.central`.

    `strength` with `numbers` is `velocity`, `obstacle_strength` with `obstacle_numbers` is what obstacles do.
    """

    strength: Strength
    numbers: Numbers
    obstacle_strength: Strength
    obstacle_numbers: Numbers

    def reach_m(self, spacing_m: float) -> float:
        """Return the distance from which on two vehicles do nothing to each other (m; inf: none)."""


def make_separation(section: Section) -> SeparationLaw:
    """Return the separation law of a section."""
    made = class_of(__name__, section.kind, "Separation")(section.params)
    law: SeparationLaw = fulfilled(made, SeparationLaw)
    return law


def obstacle_velocity_of(law: SeparationLaw) -> Callable[[Vec3, Vec3, float], Vec3]:
    """Return the function of an `ObstacleLaw`, or that for vehicles where obstacles are treated so."""
    return law.obstacle_velocity if isinstance(law, ObstacleLaw) else law.velocity
