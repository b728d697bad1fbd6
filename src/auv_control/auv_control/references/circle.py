"""
Horizontal circle about the origin at a constant depth, thesis Eqs. (2.48), (3.37)-(3.38), (5.44) and (6.47).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_control.references import PathPoint, ReferencePath
from auv_core.geometry import Box
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """The defaults are the thesis's path."""

    radius_m: float = param("radius of the circle (m)", default=10.0, above=0.0, maximum=1e5)
    rate_radps: float = param(
        "angular rate along the circle (rad/s)", default=0.01, minimum=-10.0, maximum=10.0
    )
    depth_m: float = param("depth of the circle (m; NED z)", default=10.0, minimum=0.0, maximum=1e5)
    heading_rad: float = param("heading to hold (rad, from north towards east)", default=math.pi / 3.0)
    heading: str = param(
        "whether to hold heading_rad (fixed) or to point along the path (tangent)",
        default="fixed",
        choices=("fixed", "tangent"),
    )


class Reference(ReferencePath):
    """eta_d(t) = (R sin W t, R cos W t, depth): it starts R east of the origin, heading north."""

    def __init__(self, params: Params) -> None:
        self._params = params
        self._speed_mps = params.radius_m * params.rate_radps
        self._pull_mps2 = self._speed_mps * params.rate_radps
        self.period_s = 2.0 * math.pi / abs(params.rate_radps) if params.rate_radps else None

    def reach(self, duration_s: float) -> Box:
        """Return a box that contains the path (m; NED)."""
        radius_m, depth_m = self._params.radius_m, self._params.depth_m
        return Box((-radius_m, -radius_m, depth_m), (radius_m, radius_m, depth_m))

    def at(self, t_s: float) -> PathPoint:
        """Return the point of the path at `t_s`."""
        p, speed_mps, pull_mps2 = self._params, self._speed_mps, self._pull_mps2
        angle = p.rate_radps * t_s
        sine, cosine = math.sin(angle), math.cos(angle)
        heading_rad, heading_rate_radps = p.heading_rad, 0.0
        if p.heading == "tangent":
            heading_rad, heading_rate_radps = math.remainder(_course(p, angle), 2.0 * math.pi), -p.rate_radps
        return PathPoint(
            (p.radius_m * sine, p.radius_m * cosine, p.depth_m),
            (speed_mps * cosine, -speed_mps * sine, 0.0),
            (-pull_mps2 * sine, -pull_mps2 * cosine, 0.0),
            heading_rad,
            heading_rate_radps,
        )


def _course(params: Params, angle: float) -> float:
    return -angle if params.rate_radps >= 0.0 else math.pi - angle
