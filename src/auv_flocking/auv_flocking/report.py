"""
The report that a vehicle broadcasts, as a record. A format of the folder ``reports`` converts it to bytes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from auv_core.geometry import Box, Vec3

NEVER = -math.inf


class ReportError(ValueError):
    """Raised for bytes that are not a report, or numbers that cannot be sent in one."""


class Report(NamedTuple):
    """
    State of one vehicle at its time tag.

    position, centre: m; velocity, centre_rate, flock_velocity: m/s; all NED. `flock_stamp_s`: time at which
    a leader set this flock velocity, never later than the time tag; `NEVER` if none was received.
    `position_sd_m`: standard deviation of the sender's navigation, per horizontal axis. `shared`: the numbers
    that the sender's consensus filter adds.
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
    """Return which coordinate of a position (m; NED) a format cannot carry, or an empty text."""
    (north, east, down), (least, most) = position, carried
    if least[0] <= north <= most[0] and least[1] <= east <= most[1] and least[2] <= down <= most[2]:
        return ""
    for axis, value, least_m, most_m in zip(_AXES, position, least, most, strict=True):
        if not least_m <= value <= most_m:
            return f"{axis} {value:.1f} m, allowed: {least_m:g} to {most_m:g} m"
    return ""
