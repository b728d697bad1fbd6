"""Guidance and autopilots of one vehicle along a path, which can be changed under way."""

from __future__ import annotations

from auv_control.guidance.autopilots import (
    AutopilotGains,
    AutopilotState,
    Setpoint,
    initial_state,
    measured,
    piloted,
)
from auv_control.guidance.crab import CrabLaw
from auv_control.guidance.line_of_sight import Sight, over_ground, sight
from auv_control.guidance.paths import GuidancePath, Place
from auv_control.guidance.track import TrackPoint
from auv_core.integrate import State
from auv_core.messages import FinCommand, VehicleState


class Follower:
    """
    The states of path, crab law and autopilots.

    In a control period call `look`, then `steer`. After `look`: `point` (the closest point of the path) and
    `s_m` (the path parameter, m).

    Parameters
    ----------
    path : GuidancePath
        The path at the start.
    crab : CrabLaw
        Crab law.
    gains : AutopilotGains
        Of the autopilots.
    period_s : float
        Control period (s).

    """

    point: TrackPoint
    s_m: float

    def __init__(self, path: GuidancePath, crab: CrabLaw, gains: AutopilotGains, period_s: float) -> None:
        self._path, self._crab, self._gains, self._period_s = path, crab, gains, period_s
        self._place: Place | None = None
        self._crab_state: State | None = None
        self._pilot: AutopilotState | None = None

    def change_to(self, path: GuidancePath) -> None:
        """Follow another path from now on; it is entered at its closest point."""
        if path is not self._path:
            self._path, self._place = path, None

    def look(self, nav: VehicleState, lane_m: float) -> Sight:
        """Return what guidance finds on the way along a lane at an offset to starboard of the path (m)."""
        own = over_ground(nav)
        if self._place is None:
            self._place = self._path.engage(own.north_m, own.east_m)
        else:
            self._place = self._path.follow(self._place, own.north_m, own.east_m)
        self.point, self.s_m = self._path.point(self._place), self._place.s_m
        found = sight(own, self.point, lane_m, self._crab, self._crab_state)
        self._crab_state = found.crab
        return found

    def steer(
        self, nav: VehicleState, found: Sight, depth_m: float, speed_mps: float, *, through_water: bool
    ) -> FinCommand:
        """
        Return the command of a control period.

        Parameters
        ----------
        nav : VehicleState
            The vehicle's own navigation.
        found : Sight
            What `look` found, possibly with another heading.
        depth_m, speed_mps : float
            Commanded depth (m) and speed (m/s).
        through_water : bool
            Whether the speed is through the water, where it is not measured but follows from the propeller,
            or along the line of sight over ground.

        """
        pilot = initial_state(nav.position[2]) if self._pilot is None else self._pilot
        if through_water:
            pilot = pilot._replace(speed_integral_m=0.0)
        now = measured(nav, speed_mps if through_water else found.along_mps)
        wanted = Setpoint(found.heading_rad, found.turn_rate_radps, depth_m, speed_mps)
        command, self._pilot = piloted(now, wanted, pilot, self._period_s, self._gains)
        return command
