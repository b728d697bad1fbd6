"""Horizontal circle about the origin at a constant depth and heading, thesis Eqs. (5.44) and (6.47)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.geometry import Vec3
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """The defaults are the thesis's path."""

    radius_m: float = param("radius of the circle (m)", default=10.0, above=0.0, maximum=1e5)
    rate_radps: float = param(
        "angle run through per second (rad/s)", default=0.01, minimum=-10.0, maximum=10.0
    )
    depth_m: float = param("depth of the circle (m; NED z)", default=10.0, minimum=0.0, maximum=1e5)
    heading_rad: float = param("heading to hold (rad, from north towards east)", default=math.pi / 3.0)


class Reference:
    """eta_d(t) = (R sin W t, R cos W t, depth): it starts R east of the origin, heading north."""

    def __init__(self, params: Params) -> None:
        self._params = params
        self.heading_rad = params.heading_rad
        self.period_s = 2.0 * math.pi / abs(params.rate_radps) if params.rate_radps else None

    def position(self, t_s: float) -> Vec3:
        """Return the point of the path at `t_s` (m; NED)."""
        p = self._params
        angle = p.rate_radps * t_s
        return (p.radius_m * math.sin(angle), p.radius_m * math.cos(angle), p.depth_m)

    def velocity(self, t_s: float) -> Vec3:
        """Return the velocity of that point (m/s; NED)."""
        p = self._params
        angle = p.rate_radps * t_s
        speed_mps = p.radius_m * p.rate_radps
        return (speed_mps * math.cos(angle), -speed_mps * math.sin(angle), 0.0)
