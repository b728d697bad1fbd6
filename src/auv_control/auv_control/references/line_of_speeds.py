"""Straight level line along which the speed changes in steps, such as from rest."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_control.references import PathPoint, ReferencePath
from auv_core.geometry import Box, Vec3
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """Where the line begins, its course, and the speeds along it."""

    start_ned_m: Vec3 = param("position at 0 s (m; NED)", default=(0.0, 0.0, 10.0), minimum=-1e5, maximum=1e5)
    course_rad: float = param(
        "course of the line (rad, from north towards east)", default=0.0, minimum=-math.tau, maximum=math.tau
    )
    speeds_mps: tuple[float, ...] = param(
        "speeds along the line, one after the other (m/s)", default=(0.0, 0.3), minimum=0.0, maximum=10.0
    )
    from_s: tuple[float, ...] = param(
        "scenario time from which each speed counts, the first from 0 (s)", default=(0.0, 40.0), minimum=0.0
    )
    heading_rad: float = param(
        "heading to hold (rad, from north towards east)", default=0.0, minimum=-math.tau, maximum=math.tau
    )

    def __post_init__(self) -> None:
        """Refuse times that do not begin with 0 and ascend, one for each speed."""
        times = list(self.from_s)
        if len(times) != len(self.speeds_mps) or times[:1] != [0.0] or times != sorted(set(times)):
            raise ValueError(
                f"from_s: {times!r} is not allowed; allowed: ascending times from 0, one for each of the "
                f"{len(self.speeds_mps)} speeds"
            )


class Reference(ReferencePath):
    """eta_d(t) = start + s(t) along the course; s' is the speed that counts at t."""

    period_s = None

    def __init__(self, params: Params) -> None:
        self._params = params
        self._north, self._east = math.cos(params.course_rad), math.sin(params.course_rad)
        self._legs = list(zip(params.from_s, params.speeds_mps, strict=True))

    def reach(self, duration_s: float) -> Box:
        """Return the box around both ends (m; NED)."""
        start, end = self._params.start_ned_m, self.at(duration_s).position
        low, high = zip(*(sorted(ends) for ends in zip(start, end, strict=True)), strict=True)
        return Box((low[0], low[1], low[2]), (high[0], high[1], high[2]))

    def at(self, t_s: float) -> PathPoint:
        """Return the point of the path at `t_s`."""
        way_m, speed_mps = 0.0, self._legs[0][1]
        for index, (from_s, speed_mps) in enumerate(self._legs):
            until_s = self._legs[index + 1][0] if index + 1 < len(self._legs) else math.inf
            way_m += speed_mps * (min(t_s, until_s) - from_s)
            if t_s < until_s:
                break
        x, y, z = self._params.start_ned_m
        return PathPoint(
            (x + way_m * self._north, y + way_m * self._east, z),
            (speed_mps * self._north, speed_mps * self._east, 0.0),
            heading_rad=self._params.heading_rad,
        )
