"""
References: the path in space and time that a vehicle follows.

To add one, write one file with ``Params`` and ``Reference(params)`` with ``period_s`` (time of one round, or
None), ``at(t_s) -> PathPoint``, whose rates are the exact derivatives of its values, and ``reach(duration_s)
-> Box``, a box that the path does not leave in that time (m; NED).  The file's name is its ``kind``.
"""

from __future__ import annotations

from typing import NamedTuple

from auv_core.geometry import Vec3


class PathPoint(NamedTuple):
    """
    The reference at one instant.

    Position (m), velocity (m/s) and acceleration (m/s^2) in NED; heading (rad, from north towards east) with
    its rate (rad/s) and acceleration (rad/s^2).
    """

    position: Vec3
    velocity: Vec3
    acceleration: Vec3 = (0.0, 0.0, 0.0)
    heading_rad: float = 0.0
    heading_rate_radps: float = 0.0
    heading_acceleration_radps2: float = 0.0
