"""An obstacle that goes to a second place and back, again and again, slowest at both ends."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.geometry import Vec3
from auv_core.params import param
from auv_sim.obstacles import ObstacleMotion


@dataclass(frozen=True)
class Params:
    """Where the second place is, and how long one round takes; the top speed is pi |span| / period."""

    span_ned_m: Vec3 = param(
        "from the first place to the second (m; NED)", default=(0.0, 4.0, 0.0), minimum=-1e4, maximum=1e4
    )
    round_s: float = param("time of one round, to the second place and back (s)", default=120.0, above=0.0)


class Motion(ObstacleMotion):
    """The offset s (1 - cos(2 pi t / T)) / 2."""

    def __init__(self, params: Params) -> None:
        self._params = params

    def offset(self, t_s: float) -> Vec3:
        """Return the displacement at `t_s` (m; NED)."""
        share = 0.5 * (1.0 - math.cos(2.0 * math.pi * t_s / self._params.round_s))
        north, east, down = self._params.span_ned_m
        return (share * north, share * east, share * down)
