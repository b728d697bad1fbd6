"""A circle, to loiter on."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_control.guidance.paths import GuidancePath
from auv_control.guidance.track import TrackPoint, joined
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """Centre, radius and sense."""

    north_m: float = param("centre (m; NED north)", default=0.0, minimum=-1e5, maximum=1e5)
    east_m: float = param("centre (m; NED east)", default=0.0, minimum=-1e5, maximum=1e5)
    radius_m: float = param("radius (m)", default=50.0, above=0.0, maximum=1e5)
    turn: str = param(
        "side of the turn, seen from the vehicle; starboard is clockwise",
        default="starboard",
        choices=("starboard", "port"),
    )


class Path(GuidancePath):
    """It starts abeam of the centre on the other side of the turn, heading north."""

    is_smooth = True

    def __init__(self, params: Params) -> None:
        side = 1.0 if params.turn == "starboard" else -1.0
        start = TrackPoint(params.north_m, params.east_m - side * params.radius_m, 0.0, 0.0)
        around = (math.tau * params.radius_m, side / params.radius_m)
        self.track = joined(start, (around,), is_closed=True)
