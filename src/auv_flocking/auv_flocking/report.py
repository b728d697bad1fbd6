"""
The report that a vehicle broadcasts: the record itself.  Its bytes are made by a format of the folder
``reports``.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from auv_core.geometry import Box, Vec3

NEVER = -math.inf


class ReportError(ValueError):
    """Bytes that are not a report, or numbers that cannot be sent as one."""


class Report(NamedTuple):
    """
    State of one vehicle at its time tag.

    position, centre: m; velocity, centre_rate, flock_velocity: m/s; all NED.  `flock_stamp_s`: when a leader
    made this flock velocity, on its way from vehicle to vehicle never later than a time tag; `NEVER` where
    none was heard.  `position_sd_m`: what the sender's navigation says of itself, per horizontal axis (1
    sigma).  `shared`: the numbers that the sender's consensus filter adds.
    """

    address: int
    sequence: int
    time_s: float
    position: Vec3
    velocity: Vec3
    centre: Vec3
    centre_rate: Vec3
    flock_velocity: Vec3
    flock_stamp_s: float = NEVER
    position_sd_m: float = 0.0
    shared: tuple[float, ...] = ()


_AXES = ("north", "east", "down")


def why_not_carried(position: Vec3, carried: Box) -> str:
    """Return which coordinate of a position (m; NED) is outside of what a format carries, or nothing."""
    (north, east, down), (least, most) = position, carried
    if least[0] <= north <= most[0] and least[1] <= east <= most[1] and least[2] <= down <= most[2]:
        return ""
    for axis, value, least_m, most_m in zip(_AXES, position, least, most, strict=True):
        if not least_m <= value <= most_m:
            return f"{axis} {value:.1f} m, allowed: {least_m:g} to {most_m:g} m"
    return ""
