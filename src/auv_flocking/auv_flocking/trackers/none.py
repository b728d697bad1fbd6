"""No tracker: contacts that belong to no neighbour are dropped."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.geometry import Vec3
from auv_flocking.neighbours.navigation_offset import OwnFix
from auv_flocking.neighbours.rivals import NO_RIVALS, Leftovers, Rivals
from auv_flocking.trackers import ObstacleTracker, Sensed


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


class Tracker(ObstacleTracker):
    """Nothing is tracked."""

    def __init__(self, params: Params, known: tuple[Vec3, ...]) -> None:
        del params, known

    def follow(self, fix: OwnFix) -> None:
        """Do nothing."""

    def rivals(self, t_s: float) -> Rivals:
        """Return none."""
        del t_s
        return NO_RIVALS

    def observe(self, t_s: float, left: Leftovers) -> None:
        """Do nothing."""

    def obstacles(self, t_s: float) -> Sensed:
        """Return none."""
        del t_s
        return ()
