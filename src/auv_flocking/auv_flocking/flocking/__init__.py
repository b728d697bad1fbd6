"""
Flocking laws: they compute a vehicle's velocity command from its information.

To add one, write one file with ``Params``, which are `FlockingParams`, and ``Flocking(params, separation,
member)``, a `FlockingLaw`.  The file's name is its ``kind``.  `flock_velocity` and `velocity` change
nothing, so that the sampled agent and the continuous-time runner use the same law.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

from auv_control.references import PathPoint
from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Vec3, turned
from auv_core.params import Section
from auv_flocking.neighbours.estimates import Neighbours
from auv_flocking.pings import NO_PING, Ping
from auv_flocking.separation import LearningLaw, ObstacleLearningLaw, SeparationLaw
from auv_flocking.trackers import Sensed


class FlockVelocity(NamedTuple):
    """
    An estimate of the flock's velocity (m/s; NED) at the time at which a leader set it (s), and the rate at
    which it turns about the vertical since then (rad/s; from north to east).

    Vehicles pass it on with its stamp; without a leader's value the stamp is -inf.
    """

    velocity: Vec3
    stamp_s: float
    turn_rate_radps: float = 0.0

    def at(self, t_s: float) -> Vec3:
        """Return the velocity at `t_s` (m/s; NED), turned since its stamp."""
        if self.turn_rate_radps == 0.0 or math.isinf(self.stamp_s):
            return self.velocity
        return turned(self.velocity, self.turn_rate_radps * (t_s - self.stamp_s))


NOTHING_HEARD = FlockVelocity((0.0, 0.0, 0.0), -math.inf)


class Member(NamedTuple):
    """A vehicle's place in its fleet: whether it leads, its address from 1, and the number of vehicles."""

    is_leader: bool = False
    address: int = 1
    fleet_size: int = 1


class View(NamedTuple):
    """
    The information of one vehicle at one instant; positions in m, velocities in m/s, all NED.

    `neighbours` are the positions of `estimates`, in the same order; in continuous time, with perfect
    information, there are no estimates. `obstacles` are the known ones, `sensed` those that the vehicle's
    sonar found, `ping` what it showed last, with its age.
    """

    position: Vec3
    centre: Vec3
    flock_velocity: Vec3
    neighbours: Sequence[Vec3]
    obstacles: tuple[tuple[Vec3, float], ...]
    path: PathPoint
    estimates: Neighbours = ()
    sensed: Sensed = ()
    ping: Ping = NO_PING


class FlockingParams(Protocol):
    """Properties of a law for the checks of a scenario against reports and actuators."""

    @property
    def formation_spacing_m(self) -> float:
        """Largest distance that the law keeps between neighbours (m)."""

    @property
    def largest_correction_mps(self) -> float:
        """Largest speed that the law adds to the velocity of the path (m/s; inf for no limit)."""

    @property
    def uses_flock_velocity(self) -> bool:
        """Whether `velocity` uses the flock's velocity or estimates, which needs packets."""


@runtime_checkable
class LayeredParams(Protocol):
    """Parameters of a law that gives each vehicle a layer of depth."""

    def height_m(self, fleet_size: int) -> float:
        """Return the distance of the highest and the lowest layer of a fleet (m); 0 without layers."""


class FlockingLaw(Protocol):
    """
    Computes the velocity command of a vehicle.

    `is_staying`: whether the vehicle stays where it is and does not go with the flock. Its reports say
    so, and the others predict it there.
    """

    is_staying: bool = False

    def hear(self, estimates: Neighbours, dt_s: float) -> None:
        """Measure the age of the information; called first, once per control period of `dt_s`."""

    def flock_velocity(
        self, t_s: float, path: PathPoint, centre: Vec3, own: FlockVelocity, estimates: Neighbours
    ) -> FlockVelocity:
        """
        Return this vehicle's estimate of the flock's velocity.

        It follows from the path point (leaders use it, blind followers must not), the own estimate of the
        centre, the own latest value and those in the neighbours' estimates.
        """

    def velocity(self, view: View) -> Vec3:
        """Return the commanded velocity over ground (m/s; NED)."""

    def adapt(self, view: View, dt_s: float) -> None:
        """Take over what changes with the view, after `velocity`; once per control period of `dt_s`."""


@runtime_checkable
class RecordedLaw(Protocol):
    """A law whose state is recorded."""

    @property
    def state(self) -> tuple[float, ...]:
        """The law's state after `velocity`; its length does not change."""


@runtime_checkable
class RosterLaw(Protocol):
    """A law that takes vehicles for lost of which no vehicle has had news lately."""

    @property
    def vouched_s(self) -> float:
        """Age up to which a packet of a vehicle is told to the others as news (s)."""


def learn(law: LearningLaw, view: View, spacing_m: float, dt_s: float) -> None:
    """Let a separation law adapt to the distances of a view (m) for one control period of `dt_s`."""
    law.adapt([math.dist(view.position, other) for other in view.neighbours], spacing_m, dt_s)
    if isinstance(law, ObstacleLearningLaw):
        sensed = tuple((each.position, each.safety_distance_m) for each in view.sensed)
        gaps_m = [math.dist(view.position, place) - d for place, d in view.obstacles + sensed]
        law.adapt_to_obstacles(gaps_m, dt_s)


def make_flocking(section: Section, separation: SeparationLaw, member: Member) -> FlockingLaw:
    """Return the law of a section for one vehicle of a fleet."""
    made = class_of(__name__, section.kind, "Flocking")(section.params, separation, member)
    law: FlockingLaw = fulfilled(made, FlockingLaw)
    return law


def flocking_params(section: Section) -> FlockingParams:
    """Return the parameters of a section, typed as those of every law."""
    params: FlockingParams = fulfilled(section.params, FlockingParams)
    return params
