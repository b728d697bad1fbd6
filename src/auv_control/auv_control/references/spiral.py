"""
Spiral about the vertical axis through the origin with a constant descent rate, thesis Eqs. (3.39)-(3.40).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_control.references import PathPoint, ReferencePath
from auv_core.geometry import Box
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """The defaults are the thesis's path of the first vehicle."""

    radius_m: float = param("radius of the spiral (m)", default=10.0, above=0.0, maximum=1e5)
    rate_radps: float = param(
        "angular rate along the spiral (rad/s)", default=0.01, minimum=-10.0, maximum=10.0
    )
    depth_m: float = param("depth at time 0 (m; NED z)", default=0.0, minimum=0.0, maximum=1e5)
    depth_rate_mps: float = param("descent rate (m/s; NED z)", default=1.0, minimum=-10.0, maximum=10.0)
    heading_rad: float = param("heading to hold (rad, from north towards east)", default=math.pi / 3.0)


class Reference(ReferencePath):
    """eta_d(t) = (R sin W t, R cos W t, z_0 + c t), psi_d constant; it has no period."""

    period_s = None

    def __init__(self, params: Params) -> None:
        self._params = params

    def reach(self, duration_s: float) -> Box:
        """Return a box that contains the path from 0 to `duration_s` (m; NED)."""
        p = self._params
        depths_m = (p.depth_m, p.depth_m + p.depth_rate_mps * duration_s)
        return Box((-p.radius_m, -p.radius_m, min(depths_m)), (p.radius_m, p.radius_m, max(depths_m)))

    def at(self, t_s: float) -> PathPoint:
        """Return the point of the path at `t_s`."""
        p = self._params
        angle = p.rate_radps * t_s
        sine, cosine = math.sin(angle), math.cos(angle)
        speed_mps = p.radius_m * p.rate_radps
        pull_mps2 = speed_mps * p.rate_radps
        return PathPoint(
            position=(p.radius_m * sine, p.radius_m * cosine, p.depth_m + p.depth_rate_mps * t_s),
            velocity=(speed_mps * cosine, -speed_mps * sine, p.depth_rate_mps),
            acceleration=(-pull_mps2 * sine, -pull_mps2 * cosine, 0.0),
            heading_rad=p.heading_rad,
        )
