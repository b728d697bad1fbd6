"""A path on the map, followed by line of sight at a constant depth and speed over ground."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_control.courses import CourseLaw, Guided
from auv_control.guidance.autopilots import Setpoint
from auv_control.guidance.crab import make_crab, measured
from auv_control.guidance.feasibility import Turning, check_lane, least_radius_m
from auv_control.guidance.path_guide import PathGuide
from auv_control.guidance.paths import circle, make_path, racetrack
from auv_core.geometry import Box
from auv_core.messages import VehicleState
from auv_core.params import Section, param

_RACETRACK = Section("racetrack", racetrack.Params())
_MEASURED = Section("measured", measured.Params())


@dataclass(frozen=True)
class Params:
    """The path, where on it and how fast."""

    path: Section = param("path on the map", default=_RACETRACK, plugins="auv_control.guidance.paths")
    lane_m: float = param(
        "offset of the lane to starboard of the path (m)", default=0.0, minimum=-1e3, maximum=1e3
    )
    depth_m: float = param("depth (m; NED z)", default=30.0, minimum=0.0, maximum=1e5)
    speed_mps: float = param("speed along the path over ground (m/s)", default=1.5, above=0.0, maximum=10.0)
    loiter_radius_m: float = param(
        "radius of the circle, to starboard, on which the vehicle stays after the end of an open path (m)",
        default=50.0,
        above=0.0,
        maximum=1e5,
    )
    crab: Section = param(
        "how the heading allows for the current", default=_MEASURED, plugins="auv_control.guidance.crab"
    )


class Course(CourseLaw):
    """
    It enters the path at the point that is closest at the first tick.

    At the end of an open path it goes on to a circle that touches the lane there, and stays on it.
    """

    def __init__(self, params: Params, period_s: float) -> None:
        self._params = params
        self._path = make_path(params.path)
        self._guide = PathGuide(self._path, make_crab(params.crab, period_s))
        self._loiter = None if self._path.track.is_closed else self._loiter_path()
        self._lane_m = params.lane_m

    def _loiter_path(self) -> circle.Path:
        """Return the circle that touches the lane where the path ends."""
        p, end = self._params, self._path.track.at(self._path.track.length_m)
        across_m = p.lane_m + p.loiter_radius_m
        north_m = end.north_m - across_m * math.sin(end.course_rad)
        east_m = end.east_m + across_m * math.cos(end.course_rad)
        return circle.Path(circle.Params(north_m, east_m, p.loiter_radius_m))

    def step(self, t_s: float, nav: VehicleState) -> Guided:
        """Return what the course asks at `t_s`."""
        p, found = self._params, self._guide.look(nav, self._lane_m)
        if self._loiter is not None and self._guide.s_m >= self._path.track.length_m:
            self._guide.change_to(self._loiter)
            self._lane_m = 0.0
        setpoint = Setpoint(found.heading_rad, found.turn_rate_radps, p.depth_m, p.speed_mps)
        return Guided(setpoint, found.along_mps, found.cross_track_m)

    def check(self, vehicle: Turning, current_mps: float) -> None:
        """Raise ValueError unless the vehicle can fly the lane in a current of any direction (m/s)."""
        p = self._params
        check_lane(vehicle, self._path.track, p.lane_m, p.speed_mps, current_mps)
        needed_m = least_radius_m(vehicle, p.speed_mps, current_mps)
        if self._loiter is not None and p.loiter_radius_m < needed_m:
            raise ValueError(
                f"loiter_radius_m: {p.loiter_radius_m!r} is not allowed; allowed: at least {needed_m:.3g} m "
                f"at {p.speed_mps:g} m/s in a current of {current_mps:g} m/s"
            )

    def reach(self, duration_s: float) -> Box | None:
        """Return a box around the path and what follows it (m; NED)."""
        track, lane_m = self._path.track, abs(self._params.lane_m)
        if self._loiter is not None:
            lane_m += 2.0 * self._params.loiter_radius_m
        (north, east, depth), (far_north, far_east, _) = track.box(0.0, track.length_m, self._params.depth_m)
        return Box((north - lane_m, east - lane_m, depth), (far_north + lane_m, far_east + lane_m, depth))
