"""A racetrack: two straights, joined by half circles."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_control.guidance.paths import GuidancePath
from auv_control.guidance.track import TrackPoint, joined
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """The defaults are the lane of the cooperative studies."""

    north_m: float = param(
        "start of the first straight (m; NED north)", default=0.0, minimum=-1e5, maximum=1e5
    )
    east_m: float = param("start of the first straight (m; NED east)", default=0.0, minimum=-1e5, maximum=1e5)
    course_rad: float = param(
        "course of the first straight (rad, from north towards east)",
        default=0.0,
        minimum=-math.tau,
        maximum=math.tau,
    )
    straight_m: float = param("length of a straight (m)", default=400.0, above=0.0, maximum=1e5)
    radius_m: float = param("radius of the half circles (m)", default=150.0, above=0.0, maximum=1e5)
    turn: str = param("side of the turns", default="starboard", choices=("starboard", "port"))


class Path(GuidancePath):
    """Straight, half circle, straight, half circle."""

    is_smooth = True

    def __init__(self, params: Params) -> None:
        side = 1.0 if params.turn == "starboard" else -1.0
        start = TrackPoint(params.north_m, params.east_m, params.course_rad, 0.0)
        straight, around = (params.straight_m, 0.0), (math.pi * params.radius_m, side / params.radius_m)
        self.track = joined(start, (straight, around, straight, around), is_closed=True)
