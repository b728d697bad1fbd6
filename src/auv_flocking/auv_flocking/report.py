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

    A report of an older version lacks some numbers. They are then NaN, or None if they are not plain numbers,
    and cannot be sent again.

    Attributes
    ----------
    address : int
        Acoustic address of the sender.
    time_s : float
        The time tag (s).
    position, velocity : (3,) tuple
        Of the sender (m, m/s; NED).
    centre : (3,) tuple
        Its estimate of the flocking centre (m; NED).
    flock_velocity : (3,) tuple
        Its estimate of the flock's velocity at the stamp (m/s; NED).
    flock_stamp_s : float
        Time at which a leader set this flock velocity, never later than the time tag; `NEVER` if none was
        received (s).
    flock_turn_rate_radps : float
        Rate at which that velocity turns about the vertical since then (rad/s; from north to east).
    heading_rad : float
        Heading of the sender (rad; from north to east).
    position_sd_m : float
        Standard deviation of the sender's navigation, per horizontal axis (m).
    is_bounded : bool or None
        Whether the error of the sender's navigation does not grow without limit.
    is_holding : bool or None
        Whether the sender holds station instead of moving with the flock.
    heard_code, heard_mask : int or None
        Age class, and which vehicles the sender has heard within it; see `auv_flocking.heard`.
    shared : tuple of float
        The numbers that the sender's consensus filter adds.

    """

    address: int
    time_s: float
    position: Vec3
    velocity: Vec3
    centre: Vec3
    flock_velocity: Vec3
    flock_stamp_s: float = NEVER
    flock_turn_rate_radps: float = 0.0
    heading_rad: float = 0.0
    position_sd_m: float = 0.0
    is_bounded: bool | None = False
    is_holding: bool | None = False
    heard_code: int | None = 0
    heard_mask: int | None = 0
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
