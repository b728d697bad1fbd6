"""
Forces on a slender hull with fins and a propeller: lift and drag, cross-flow strips, open-water lines.

Symbols: u, v, w, p, q, r are the velocity relative to the water (m/s, rad/s; body FRD); a force is [X, Y, Z]
(N) with [K, M, N] (N m), body frame.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from auv_core.compiled import inlined, record
from auv_core.geometry import Vec3
from auv_core.models._torpedo_body import Forces

STRIPS = 20
"""Intervals between the strips of cross-flow drag; there is one strip more."""
_STALL_RAD = 0.35
_STALL_SHARPNESS = 50.0
_FADING_SPM = 3.0


@record(", ".join(22 * ["float64"]))
class Water(NamedTuple):
    """
    The constants of the forces of the water and of the actuators.

    damping_surge_kgps, ..., damping_yaw_nms: linear damping at rest.  pressure_kgpm: rho S / 2.  lift: C_L
    per angle (1/rad).  drag: C_D at zero angle.  induced_drag: C_D per C_L^2.  strip_kgpm: rho / 2 D C_d dx.
    is_vertical, lifts_sideways: 1 if there is cross-flow drag in the vertical plane, lift in sway, else 0.
    length_m.  rudder_kgpm, stern_plane_kgpm: rho / 2 A C_L of the fins.  fin_x_m: their place.  thrust_kgm:
    (1 - t) rho D^4 K_T at rest.  advance_thrust_kg: what the speed of the hull adds, (1 - t) rho D^3 (1 - w)
    dK_T/dJ.  roll_kgm2, advance_roll_kgm: the same of the roll moment.  is_by_ground: 1 if the propeller
    meets the speed over ground, else 0.
    """

    damping_surge_kgps: float
    damping_sway_kgps: float
    damping_heave_kgps: float
    damping_roll_nms: float
    damping_pitch_nms: float
    damping_yaw_nms: float
    pressure_kgpm: float
    lift: float
    drag: float
    induced_drag: float
    strip_kgpm: float
    is_vertical: float
    lifts_sideways: float
    length_m: float
    rudder_kgpm: float
    stern_plane_kgpm: float
    fin_x_m: float
    thrust_kgm: float
    advance_thrust_kg: float
    roll_kgm2: float
    advance_roll_kgm: float
    is_by_ground: float


@inlined
def _unstalled(angle_rad: float) -> float:
    """
    Return the part of the lift that is left at an angle of attack (rad): 1 minus the sigmoid of Beard and
    McLain (2012).

    The exponents stay below 175 for angles up to pi, so that nothing overflows.
    """
    ahead = math.exp(-_STALL_SHARPNESS * (angle_rad - _STALL_RAD))
    astern = math.exp(_STALL_SHARPNESS * (angle_rad + _STALL_RAD))
    return 1.0 - (1.0 + ahead + astern) / ((1.0 + ahead) * (1.0 + astern))


@inlined
def wing_force(
    ahead_mps: float, across_mps: float, pressure_n: float, drag: float, c: Water
) -> tuple[float, float]:
    """
    Return the force of lift and drag ahead and across (N) in the plane of two components of the velocity.

    `pressure_n` is rho U^2 S / 2 (N), `drag` the drag coefficient at zero angle.
    """
    size = math.sqrt(ahead_mps * ahead_mps + across_mps * across_mps)
    if size == 0.0:
        return 0.0, 0.0
    cosine, sine = ahead_mps / size, across_mps / size
    angle_rad = math.atan2(across_mps, ahead_mps)
    whole = c.lift * angle_rad
    left = _unstalled(angle_rad)
    lifting, dragging = left * whole, drag + left * (c.induced_drag * whole * whole)
    return (
        -pressure_n * (dragging * cosine - lifting * sine),
        -pressure_n * (dragging * sine + lifting * cosine),
    )


@inlined
def _cross_flow(across_mps: float, turning_radps: float, length_m: float) -> tuple[float, float]:
    """
    Return the sums of |a| a (m^2/s^2) and x |a| a (m^3/s^2) over the strips at x, a = across + x turning.
    """
    force, moment = 0.0, 0.0
    for strip in range(STRIPS + 1):
        x_m = length_m * (strip - 0.5 * STRIPS) / STRIPS
        speed_mps = across_mps + x_m * turning_radps
        drag = abs(speed_mps) * speed_mps
        force += drag
        moment += x_m * drag
    return force, moment


@inlined
def hull_force(water: Vec3, rates: Vec3, c: Water) -> Forces:
    """Return the force of damping, lift, drag and cross-flow drag."""
    u, v, w = water
    p, q, r = rates
    square = u * u + v * v + w * w
    fading = math.exp(-_FADING_SPM * math.sqrt(square))
    pressure_n = c.pressure_kgpm * square
    lift_x, lift_z = wing_force(u, w, pressure_n, c.drag, c)
    if c.lifts_sideways > 0.0:
        side_x, side_y = wing_force(u, v, pressure_n, 0.0, c)
    else:
        side_x, side_y = 0.0, 0.0
    sway, yaw = _cross_flow(v, r, c.length_m)
    heave, pitch = _cross_flow(w, -q, c.length_m)
    vertical = c.strip_kgpm * c.is_vertical
    return (
        (
            lift_x + side_x - fading * c.damping_surge_kgps * u,
            side_y - fading * c.damping_sway_kgps * v - c.strip_kgpm * sway,
            lift_z - c.damping_heave_kgps * w - vertical * heave,
        ),
        (
            -c.damping_roll_nms * p,
            vertical * pitch - c.damping_pitch_nms * q,
            -c.damping_yaw_nms * r - c.strip_kgpm * yaw,
        ),
    )


@inlined
def fin_force(water: Vec3, rudder_rad: float, stern_plane_rad: float, c: Water) -> Forces:
    """Return the force of rudder and stern planes, with the drag that their lift costs."""
    u, v, w = water
    rudder_n = c.rudder_kgpm * (u * u + v * v) * rudder_rad
    stern_plane_n = c.stern_plane_kgpm * (u * u + w * w) * stern_plane_rad
    drag_n = rudder_n * rudder_rad + stern_plane_n * stern_plane_rad
    return (-drag_n, -rudder_n, -stern_plane_n), (0.0, c.fin_x_m * stern_plane_n, -c.fin_x_m * rudder_n)


@inlined
def propeller_force(speed_mps: float, propeller_rpm: float, c: Water) -> tuple[float, float]:
    """Return thrust (N) and roll moment (N m) at a speed through the water; astern without advance."""
    turns_ps = propeller_rpm / 60.0
    advance_mps = speed_mps if turns_ps > 0.0 else 0.0
    size_ps = abs(turns_ps)
    return (
        (c.thrust_kgm * turns_ps + c.advance_thrust_kg * advance_mps) * size_ps,
        (c.roll_kgm2 * turns_ps + c.advance_roll_kgm * advance_mps) * size_ps,
    )
