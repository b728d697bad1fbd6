"""
Trackers of obstacles: what a vehicle makes of sonar contacts that belong to none of its neighbours.

To add one, write one file with ``Params`` and ``Tracker(params, known)``, an `ObstacleTracker`; `known` are
the positions of the obstacles that the vehicle knows from the start (m; NED).  The file's name is its
``kind``.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Vec3
from auv_core.params import Section
from auv_flocking.neighbours.navigation_offset import OwnFix
from auv_flocking.neighbours.rivals import Leftovers, Rivals


class SensedObstacle(NamedTuple):
    """
    An obstacle as a vehicle estimates it, in the frame of its own navigation.

    number: name of the track, from 1; position (m; NED) and velocity (m/s; NED) now; sigma_m: standard
    deviation of the position along its most uncertain axis; age_s: time since the newest contact;
    safety_distance_m: distance at which the vehicle begins to avoid it.
    """

    number: int
    position: Vec3
    velocity: Vec3
    sigma_m: float
    age_s: float
    safety_distance_m: float


Sensed = tuple[SensedObstacle, ...]


class ObstacleTracker(Protocol):
    """The obstacles that one vehicle senses; in a period `follow`, `rivals`, `observe`, `obstacles`."""

    def follow(self, fix: OwnFix) -> None:
        """Move into the frame of the own navigation after a fix."""

    def rivals(self, t_s: float) -> Rivals:
        """Return the objects that compete with neighbours for contacts at `t_s`."""

    def observe(self, t_s: float, left: Leftovers) -> None:
        """Use the contacts of one ping that no neighbour took; `left` refers to the rows of `rivals`."""

    def obstacles(self, t_s: float) -> Sensed:
        """Return the obstacles to avoid at `t_s`, in the order of their numbers."""


def make_tracker(section: Section, known: tuple[Vec3, ...]) -> ObstacleTracker:
    """Return the tracker of a section."""
    made = class_of(__name__, section.kind, "Tracker")(section.params, known)
    tracker: ObstacleTracker = fulfilled(made, ObstacleTracker)
    return tracker
