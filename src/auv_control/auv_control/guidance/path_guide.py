"""Guidance of one vehicle along a path, which can be changed under way."""

from __future__ import annotations

from auv_control.guidance.crab import CrabLaw
from auv_control.guidance.line_of_sight import Sight, over_ground, sight
from auv_control.guidance.paths import GuidancePath, Place
from auv_control.guidance.track import TrackPoint
from auv_core.integrate import State
from auv_core.messages import VehicleState


class PathGuide:
    """
    The place on the path and the state of the crab law.

    After `look`: `point` (the closest point of the path) and `s_m` (the path parameter, m).

    Parameters
    ----------
    path : GuidancePath
        The path at the start.
    crab : CrabLaw
        Crab law.

    """

    point: TrackPoint
    s_m: float

    def __init__(self, path: GuidancePath, crab: CrabLaw) -> None:
        self._path, self._crab = path, crab
        self._place: Place | None = None
        self._crab_state: State | None = None

    def change_to(self, path: GuidancePath) -> None:
        """Follow another path from now on; it is entered at its closest point."""
        if path is not self._path:
            self._path, self._place = path, None

    def look(self, nav: VehicleState, lane_m: float) -> Sight:
        """
        Return what guidance finds in one control period.

        Parameters
        ----------
        nav : VehicleState
            The vehicle's own navigation.
        lane_m : float
            Offset of the lane to starboard of the path (m).

        """
        own = over_ground(nav)
        if self._place is None:
            self._place = self._path.engage(own.north_m, own.east_m)
        else:
            self._place = self._path.follow(self._place, own.north_m, own.east_m)
        self.point, self.s_m = self._path.point(self._place), self._place.s_m
        found = sight(own, self.point, lane_m, self._crab, self._crab_state)
        self._crab_state = found.crab
        return found
