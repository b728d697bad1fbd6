"""A lawnmower: parallel legs, joined by half circles on alternate sides."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_control.guidance.paths import GuidancePath
from auv_control.guidance.track import TrackPoint, joined
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """Legs, and the half circles between them; legs are two radii apart."""

    north_m: float = param("start of the first leg (m; NED north)", default=0.0, minimum=-1e5, maximum=1e5)
    east_m: float = param("start of the first leg (m; NED east)", default=0.0, minimum=-1e5, maximum=1e5)
    course_rad: float = param(
        "course of the first leg (rad, from north towards east)",
        default=0.0,
        minimum=-math.tau,
        maximum=math.tau,
    )
    legs: int = param("number of legs", default=4, minimum=1, maximum=1000)
    leg_m: float = param("length of a leg (m)", default=200.0, above=0.0, maximum=1e5)
    radius_m: float = param("radius of the half circles (m)", default=50.0, above=0.0, maximum=1e5)
    first_turn: str = param("side of the first turn", default="starboard", choices=("starboard", "port"))


class Path(GuidancePath):
    """Leg, half circle, leg, half circle to the other side, and so on; an open path."""

    is_smooth = True

    def __init__(self, params: Params) -> None:
        side = 1.0 if params.first_turn == "starboard" else -1.0
        start = TrackPoint(params.north_m, params.east_m, params.course_rad, 0.0)
        parts = [(params.leg_m, 0.0)]
        for _ in range(params.legs - 1):
            parts += [(math.pi * params.radius_m, side / params.radius_m), (params.leg_m, 0.0)]
            side = -side
        self.track = joined(start, parts, is_closed=False)
