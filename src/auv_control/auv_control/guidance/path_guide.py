"""Guidance of one vehicle along a path, which can be changed under way."""

from __future__ import annotations

from auv_control.guidance.crab import CrabLaw
from auv_control.guidance.line_of_sight import Aim, Sight, aim_at_lane, sight
from auv_control.guidance.paths import GuidancePath, Place
from auv_core.compiled import fastest
from auv_core.integrate import State
from auv_core.messages import VehicleState


class PathGuide:
    """
    The place on the path and the state of the crab law.

    After `look`: `s_m` (the path parameter, m) and `curvature_pm` (of the path there, 1/m).

    Parameters
    ----------
    path : GuidancePath
        The path at the start.
    crab : CrabLaw
        Crab law.

    """

    s_m: float
    curvature_pm: float

    def __init__(self, path: GuidancePath, crab: CrabLaw) -> None:
        self._path, self._crab = path, crab
        self._aim_at_lane = fastest(aim_at_lane)
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
        north_m, east_m, _ = nav.position
        if self._place is None:
            self._place = self._path.engage(north_m, east_m)
        else:
            self._place = self._path.follow(self._place, north_m, east_m)
        index, self.s_m = self._place
        track, law = self._path.track, self._crab
        numbers = self._aim_at_lane(
            nav.numbers, track.rows, track.round_m, index, self.s_m, lane_m, law.lookahead_m
        )
        aim = Aim(*numbers)
        self.curvature_pm = aim.curvature_pm
        found = sight(aim, law, self._crab_state)
        self._crab_state = found.crab
        return found
