"""
Line-of-sight guidance along a lane: heading and turn rate from the cross-track error.

    psi_ref = chi - atan(y_e / Delta) - beta
    r_ref   = kappa_y v_g cos^2(atan(y_e / Delta)) - Delta / (Delta^2 + y_e^2) v_g sin(chi_g - chi)

(Fossen 2021, Handbook of Marine Craft Hydrodynamics and Motion Control, ch. 12). chi and kappa are course and
curvature of the track, y_e is the cross-track error to starboard of the lane, chi_g and v_g are course and
speed over ground, and kappa_y = kappa / (1 - kappa (o_y + y_e)) is the curvature of the parallel curve
through the vehicle. beta is the crab angle of a law of the folder ``crab``. The turn rate is the derivative
of psi_ref without beta, which the heading autopilot feeds forward.

Deviation: the speed counts along the line of sight, v_g cos(chi_g - chi + atan(y_e / Delta)), and not along
the tangent, where it would vanish at a corner or beside a lane, so that the speed autopilot would race. On
the lane both are equal.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from auv_control.guidance.crab import CrabLaw, CrabView
from auv_control.guidance.track import TrackPoint, seen_from
from auv_core.geometry import body_to_ned, clipped, heading_from_quaternion, smallest_angle
from auv_core.integrate import State
from auv_core.messages import VehicleState

TURN_RATE_MAX_RADPS = math.radians(4.5)
_LEAST_SLOPE = 0.2


class OverGround(NamedTuple):
    """Horizontal position (m; NED), course (rad) and speed over ground (m/s), and heading (rad)."""

    north_m: float
    east_m: float
    course_rad: float
    speed_mps: float
    heading_rad: float


class Sight(NamedTuple):
    """
    What guidance finds.

    The commanded heading (rad) and turn rate (rad/s), the cross-track error (m, to starboard of the lane),
    course over ground minus course of the lane (rad), speed along the line of sight (m/s), and the state of
    the crab law.
    """

    heading_rad: float
    turn_rate_radps: float
    cross_track_m: float
    course_error_rad: float
    along_mps: float
    crab: State


def over_ground(nav: VehicleState) -> OverGround:
    """Return the horizontal motion in a vehicle's navigation; at rest the heading counts as the course."""
    u, v, w, _, _, _ = nav.nu
    north_mps, east_mps, _ = body_to_ned(nav.attitude, (u, v, w))
    heading_rad = heading_from_quaternion(nav.attitude)
    speed_mps = math.hypot(north_mps, east_mps)
    course_rad = math.atan2(east_mps, north_mps) if speed_mps > 0.0 else heading_rad
    return OverGround(nav.position[0], nav.position[1], course_rad, speed_mps, heading_rad)


def sight(own: OverGround, point: TrackPoint, lane_m: float, law: CrabLaw, crab: State | None) -> Sight:
    """
    Return what guidance finds in one control period.

    Parameters
    ----------
    own : OverGround
        The vehicle's motion.
    point : TrackPoint
        The point of the track that is closest to the vehicle.
    lane_m : float
        Offset of the lane to starboard of the track o_y (m).
    law : CrabLaw
        Crab law, which has the lookahead distance.
    crab : tuple or None
        State of the crab law after the last control period; None at the start.

    """
    error_m = seen_from(point, own.north_m, own.east_m).across_m - lane_m
    course_error = smallest_angle(own.course_rad - point.course_rad)
    view = CrabView(error_m, course_error, smallest_angle(own.course_rad - own.heading_rad))
    beta, crab = law.step(law.initial_state(view) if crab is None else crab, view)
    ahead_m = law.lookahead_m
    towards = math.atan(error_m / ahead_m)
    square_m2 = ahead_m * ahead_m + error_m * error_m
    slope = max(1.0 - point.curvature_pm * (lane_m + error_m), _LEAST_SLOPE)
    turn = point.curvature_pm / slope * ahead_m * ahead_m - ahead_m * math.sin(course_error)
    return Sight(
        point.course_rad - towards - beta,
        clipped(own.speed_mps * turn / square_m2, TURN_RATE_MAX_RADPS),
        error_m,
        course_error,
        own.speed_mps * math.cos(course_error + towards),
        crab,
    )
