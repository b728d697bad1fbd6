"""Straight line with a constant velocity."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_control.references import PathPoint, ReferencePath
from auv_core.geometry import Box, Vec3
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """Where the line begins, and the velocity along it."""

    start_ned_m: Vec3 = param("position at 0 s (m; NED)", default=(0.0, 0.0, 10.0), minimum=-1e5, maximum=1e5)
    velocity_ned_mps: Vec3 = param(
        "velocity along the line (m/s; NED)", default=(0.1, 0.0, 0.0), minimum=-10.0, maximum=10.0
    )
    heading_rad: float = param(
        "heading to hold (rad, from north towards east)", default=0.0, minimum=-math.tau, maximum=math.tau
    )


class Reference(ReferencePath):
    """eta_d(t) = start + velocity t."""

    period_s = None

    def __init__(self, params: Params) -> None:
        self._params = params

    def reach(self, duration_s: float) -> Box:
        """Return the box around both ends (m; NED)."""
        start, end = self._params.start_ned_m, self.at(duration_s).position
        low, high = zip(*(sorted(ends) for ends in zip(start, end, strict=True)), strict=True)
        return Box((low[0], low[1], low[2]), (high[0], high[1], high[2]))

    def at(self, t_s: float) -> PathPoint:
        """Return the point of the path at `t_s`."""
        (x, y, z), v = self._params.start_ned_m, self._params.velocity_ned_mps
        place = (x + v[0] * t_s, y + v[1] * t_s, z + v[2] * t_s)
        return PathPoint(place, v, heading_rad=self._params.heading_rad)
