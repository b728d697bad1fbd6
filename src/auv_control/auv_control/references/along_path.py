"""
A path on the map at a constant speed: waypoints, a racetrack or a lawnmower for a vehicle that can stop.

On an open path the reference stops at the end.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_control.guidance.paths import make_path, waypoints
from auv_control.references import PathPoint, ReferencePath
from auv_core.geometry import Box
from auv_core.params import Section, param

_WAYPOINTS = Section("waypoints", waypoints.Params())


@dataclass(frozen=True)
class Params:
    """The path on the map, depth and speed."""

    path: Section = param(
        "path on the map, whose corners are rounded", default=_WAYPOINTS, plugins="auv_control.guidance.paths"
    )
    speed_mps: float = param("speed along the path (m/s)", default=0.1, above=0.0, maximum=10.0)
    depth_m: float = param("depth of the path (m; NED z)", default=10.0, minimum=0.0, maximum=1e5)
    heading_rad: float = param(
        "heading to hold (rad, from north towards east)", default=0.0, minimum=-math.tau, maximum=math.tau
    )
    heading: str = param(
        "whether to hold heading_rad (fixed) or to point along the path (tangent)",
        default="fixed",
        choices=("fixed", "tangent"),
    )

    def __post_init__(self) -> None:
        if not make_path(self.path).is_smooth:
            raise ValueError(
                "path.params.corners: 'switched' is not allowed; allowed: rounded, since a reference has a "
                "velocity everywhere"
            )


class Reference(ReferencePath):
    """eta_d(t) = the point of the path at the parameter s = U t."""

    def __init__(self, params: Params) -> None:
        self._params = params
        self._track = make_path(params.path).track
        self.period_s = self._track.length_m / params.speed_mps if self._track.is_closed else None

    def reach(self, duration_s: float) -> Box:
        """Return the smallest box around the path in that time (m; NED)."""
        return self._track.box(0.0, self._parameter_m(duration_s), self._params.depth_m)

    def at(self, t_s: float) -> PathPoint:
        """Return the point of the path at `t_s`."""
        p = self._params
        point = self._track.at(self._parameter_m(t_s))
        ends = not self._track.is_closed and p.speed_mps * t_s >= self._track.length_m
        speed_mps = 0.0 if ends else p.speed_mps
        c, s = math.cos(point.course_rad), math.sin(point.course_rad)
        turn_radps = point.curvature_pm * speed_mps
        points_along = p.heading == "tangent"
        return PathPoint(
            (point.north_m, point.east_m, p.depth_m),
            (speed_mps * c, speed_mps * s, 0.0),
            (-speed_mps * turn_radps * s, speed_mps * turn_radps * c, 0.0),
            math.remainder(point.course_rad, math.tau) if points_along else p.heading_rad,
            turn_radps if points_along else 0.0,
        )

    def _parameter_m(self, t_s: float) -> float:
        s_m = self._params.speed_mps * t_s
        return s_m if self._track.is_closed else min(s_m, self._track.length_m)
