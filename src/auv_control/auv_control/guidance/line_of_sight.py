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
from auv_control.guidance.track import Floats, TrackPoint, point_at, seen_from
from auv_core.compiled import entry, inner
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


class Aim(NamedTuple):
    """
    What guidance finds before it allows for the crab angle.

    The numbers of `Sight` without the last, course over ground minus heading (rad), and the curvature of the
    track (1/m).
    """

    heading_rad: float
    turn_rate_radps: float
    cross_track_m: float
    course_error_rad: float
    along_mps: float
    drift_rad: float
    curvature_pm: float


def over_ground(nav: VehicleState) -> OverGround:
    """Return the horizontal motion in a vehicle's navigation; at rest the heading counts as the course."""
    return moving(nav.numbers)


@inner
def moving(state: State) -> OverGround:
    """Return the horizontal motion in the 13 numbers of a `VehicleState`."""
    attitude = (state[3], state[4], state[5], state[6])
    north_mps, east_mps, _ = body_to_ned(attitude, (state[7], state[8], state[9]))
    heading_rad = heading_from_quaternion(attitude)
    speed_mps = math.sqrt(north_mps * north_mps + east_mps * east_mps)
    course_rad = math.atan2(east_mps, north_mps) if speed_mps > 0.0 else heading_rad
    return OverGround(state[0], state[1], course_rad, speed_mps, heading_rad)


@inner
def aimed(own: OverGround, point: TrackPoint, lane_m: float, lookahead_m: float) -> Aim:
    """
    Return what guidance finds in one control period before it allows for the crab angle.

    Parameters
    ----------
    own : OverGround
        The vehicle's motion.
    point : TrackPoint
        The point of the track that is closest to the vehicle.
    lane_m : float
        Offset of the lane to starboard of the track o_y (m).
    lookahead_m : float
        Lookahead distance Delta (m).

    """
    error_m = seen_from(point, own.north_m, own.east_m).across_m - lane_m
    course_error = smallest_angle(own.course_rad - point.course_rad)
    towards = math.atan(error_m / lookahead_m)
    square_m2 = lookahead_m * lookahead_m + error_m * error_m
    slope = max(1.0 - point.curvature_pm * (lane_m + error_m), _LEAST_SLOPE)
    turn = point.curvature_pm / slope * lookahead_m * lookahead_m - lookahead_m * math.sin(course_error)
    return Aim(
        point.course_rad - towards,
        clipped(own.speed_mps * turn / square_m2, TURN_RATE_MAX_RADPS),
        error_m,
        course_error,
        own.speed_mps * math.cos(course_error + towards),
        smallest_angle(own.course_rad - own.heading_rad),
        point.curvature_pm,
    )


@entry("TUPLE7(TUPLE13, float64[:, ::1], float64, int64, float64, float64, float64)", allocates=False)
def aim_at_lane(
    state: State, rows: Floats, round_m: float, index: int, s_m: float, lane_m: float, lookahead_m: float
) -> State:
    """
    Return the numbers of `Aim`.

    Parameters
    ----------
    state : (13,) tuple
        Position (m; NED), attitude and nu of the vehicle's own navigation.
    rows, round_m, index, s_m
        The track as of `piece_at`, the piece that the vehicle follows, and its path parameter (m).
    lane_m, lookahead_m
        As of `aimed`.

    """
    aim = aimed(moving(state), point_at(rows, round_m, index, s_m), lane_m, lookahead_m)
    return (
        aim.heading_rad, aim.turn_rate_radps, aim.cross_track_m, aim.course_error_rad,
        aim.along_mps, aim.drift_rad, aim.curvature_pm,
    )  # fmt: skip


def sight(aim: Aim, law: CrabLaw, crab: State | None) -> Sight:
    """
    Return what guidance finds in one control period.

    Parameters
    ----------
    aim : Aim
        What it finds before.
    law : CrabLaw
        Crab law.
    crab : tuple or None
        State of the crab law after the last control period; None at the start.

    """
    view = CrabView(aim.cross_track_m, aim.course_error_rad, aim.drift_rad)
    beta, crab = law.step(law.initial_state(view) if crab is None else crab, view)
    return Sight(aim.heading_rad - beta, *aim[1:5], crab)
