"""
The turning frame of a formation: world offsets of slots, with their exact derivatives.

    w    = R o                                      R = R_z(chi)
    w'   = R o' + chi' S w                          S = R' / chi', a quarter turn in the plane
    w''  = R o'' + 2 chi' S R o' + chi'' S w - chi'^2 w      (w horizontal; z does not turn)

chi is the course: the direction of the path's velocity.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from auv_control.references import PathPoint
from auv_core.geometry import Vec3, turned


class Course(NamedTuple):
    """Course chi (rad, from north towards east), its rate (rad/s) and its acceleration (rad/s^2)."""

    chi_rad: float
    rate_radps: float = 0.0
    acceleration_radps2: float = 0.0


class Offset(NamedTuple):
    """An offset (m), its rate (m/s) and its acceleration (m/s^2); in the frame of the formation, or NED."""

    position: Vec3
    velocity: Vec3 = (0.0, 0.0, 0.0)
    acceleration: Vec3 = (0.0, 0.0, 0.0)


def course_of(path: PathPoint) -> Course:
    """
    Return the course of a path point and its rate.

    A path point has no third derivative, so that chi'' is 0: exact on lines and circles. A path that stands
    has the course of its heading.
    """
    north, east, _ = path.velocity
    if north == 0.0 and east == 0.0:
        return Course(path.heading_rad)
    return Course(math.atan2(east, north), path.turn_rate_radps)


def world_offset(slot: Offset, course: Course) -> Offset:
    """Return an offset in NED (m, m/s, m/s^2) of one in the frame of the formation."""
    chi, rate, acceleration = course
    wx, wy, wz = turned(slot.position, chi)
    vx, vy, vz = turned(slot.velocity, chi)
    ax, ay, az = turned(slot.acceleration, chi)
    return Offset(
        (wx, wy, wz),
        (vx - rate * wy, vy + rate * wx, vz),
        (
            ax - 2.0 * rate * vy - acceleration * wy - rate * rate * wx,
            ay + 2.0 * rate * vx + acceleration * wx - rate * rate * wy,
            az,
        ),
    )
