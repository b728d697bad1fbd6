"""
The motion of a rigid body, and of the hulls of `six_dof`: rates, and fixed steps of RK4 with a wrench that is
held.
"""

from __future__ import annotations

import math
from typing import Protocol

from auv_core.compiled import entry, inlined
from auv_core.geometry import Quat, Vec3
from auv_core.integrate import State, rk4
from auv_core.messages import Numbers
from auv_core.models._hull_forces import Constants, coriolis_force, damping_force


class Inertia(Protocol):
    """The mass matrix M of a hull with its centre of gravity below its origin, added mass included."""

    @property
    def surge_kg(self) -> float:
        """Mass in surge (kg)."""

    @property
    def sway_kg(self) -> float:
        """Mass in sway (kg)."""

    @property
    def heave_kg(self) -> float:
        """Mass in heave (kg)."""

    @property
    def roll_kgm2(self) -> float:
        """Inertia about the forward axis (kg m^2)."""

    @property
    def pitch_kgm2(self) -> float:
        """Inertia about the starboard axis (kg m^2)."""

    @property
    def yaw_kgm2(self) -> float:
        """Inertia about the downward axis (kg m^2)."""

    @property
    def static_moment_kgm(self) -> float:
        """Static moment m z_G (kg m)."""


@inlined
def attitude_rate(attitude: Quat, rates: Vec3) -> Quat:
    """Return the rate of change of an attitude (1/s) for body rates (rad/s)."""
    qw, qx, qy, qz = attitude
    p, q, r = rates
    return (
        -0.5 * (qx * p + qy * q + qz * r),
        0.5 * (qw * p + qy * r - qz * q),
        0.5 * (qw * q + qz * p - qx * r),
        0.5 * (qw * r + qx * q - qy * p),
    )


@inlined
def acceleration(force: Vec3, moment: Vec3, rates: Vec3, current: Vec3, c: Inertia) -> tuple[Vec3, Vec3]:
    """
    Return the rate of change of nu (m/s^2, rad/s^2; body): M^-1 tau - [omega x nu_c, 0].

    Parameters
    ----------
    force, moment : (3,) tuple
        Sum of all forces (N) and moments (N m; body).
    rates, current : (3,) tuple
        Body rates (rad/s) and the velocity of the water (m/s; body).
    c : Inertia
        Of the hull.

    """
    fx, fy, fz = force
    nx, ny, nz = moment
    p, q, r = rates
    cu, cv, cw = current
    s = c.static_moment_kgm
    surge_pitch = c.surge_kg * c.pitch_kgm2 - s * s
    sway_roll = c.sway_kg * c.roll_kgm2 - s * s
    return (
        (
            (c.pitch_kgm2 * fx - s * ny) / surge_pitch - (q * cw - r * cv),
            (c.roll_kgm2 * fy + s * nx) / sway_roll - (r * cu - p * cw),
            fz / c.heave_kg - (p * cv - q * cu),
        ),
        (
            (c.sway_kg * nx + s * fy) / sway_roll,
            (c.surge_kg * ny - s * fx) / surge_pitch,
            nz / c.yaw_kgm2,
        ),
    )


@inlined
def derivative(state: State, tau: Numbers, current: Vec3, c: Constants) -> State:
    """
    Return the rate of change of the 13 floats of a state.

    Parameters
    ----------
    state : (13,) tuple
        NED position (m), quaternion body to NED (w, x, y, z), nu (m/s, rad/s; body).
    tau : (6,) tuple
        Wrench of the actuators (N, N m; body).
    current : (3,) tuple
        Velocity of the water, uniform and constant (m/s; NED).
    c : Constants
        Of the hull.

    Notes
    -----
    The water is irrotational and steady, so the equations hold for nu_r unchanged (Fossen 2021, property
    10.1); in the body frame the current changes by -omega x nu_c.

    """
    qw, qx, qy, qz = state[3:7]
    u, v, w = state[7:10]
    p, q, r = state[10:13]
    r11, r12, r13 = 1.0 - 2.0 * (qy * qy + qz * qz), 2.0 * (qx * qy - qw * qz), 2.0 * (qx * qz + qw * qy)
    r21, r22, r23 = 2.0 * (qx * qy + qw * qz), 1.0 - 2.0 * (qx * qx + qz * qz), 2.0 * (qy * qz - qw * qx)
    r31, r32, r33 = 2.0 * (qx * qz - qw * qy), 2.0 * (qy * qz + qw * qx), 1.0 - 2.0 * (qx * qx + qy * qy)
    cn, ce, cd = current
    cu = r11 * cn + r21 * ce + r31 * cd
    cv = r12 * cn + r22 * ce + r32 * cd
    cw = r13 * cn + r23 * ce + r33 * cd
    water = (u - cu, v - cv, w - cw)
    rates = (p, q, r)
    (cx, cy, cz), (ck, cm, cr) = coriolis_force(water, rates, c)
    (dx, dy, dz), (dk, dm, dn) = damping_force(water, rates, c)
    heavy, righting = c.net_weight_n, c.righting_nm
    fx = tau[0] - cx - dx + heavy * r31
    fy = tau[1] - cy - dy + heavy * r32
    fz = tau[2] - cz - dz + heavy * r33
    nx = tau[3] - ck - dk - righting * r32
    ny = tau[4] - cm - dm + righting * r31
    nz = tau[5] - cr - dn
    aw, ax, ay, az = attitude_rate((qw, qx, qy, qz), rates)
    (du, dv, dw), (dp, dq, dr) = acceleration((fx, fy, fz), (nx, ny, nz), rates, (cu, cv, cw), c)
    return (
        r11 * u + r12 * v + r13 * w,
        r21 * u + r22 * v + r23 * w,
        r31 * u + r32 * v + r33 * w,
        aw, ax, ay, az,
        du, dv, dw,
        dp, dq, dr,
    )  # fmt: skip


@inlined
def _along(x: State, h: float, k: State) -> State:
    """Return x + h k."""
    return (
        x[0] + h * k[0], x[1] + h * k[1], x[2] + h * k[2], x[3] + h * k[3], x[4] + h * k[4],
        x[5] + h * k[5], x[6] + h * k[6], x[7] + h * k[7], x[8] + h * k[8], x[9] + h * k[9],
        x[10] + h * k[10], x[11] + h * k[11], x[12] + h * k[12],
    )  # fmt: skip


@inlined
def normalised(x: State) -> State:
    """Return a state with an attitude quaternion of length 1."""
    norm = math.sqrt(x[3] * x[3] + x[4] * x[4] + x[5] * x[5] + x[6] * x[6])
    return (
        x[0], x[1], x[2], x[3] / norm, x[4] / norm, x[5] / norm, x[6] / norm,
        x[7], x[8], x[9], x[10], x[11], x[12],
    )  # fmt: skip


@inlined
def _rate(t_s: float, x: State, given: tuple[Numbers, Vec3, Constants]) -> State:
    """Return `derivative` for the wrench, current and hull given."""
    tau, current, c = given
    return derivative(x, tau, current, c)


@inlined
def stepped(x: State, tau: Numbers, current: Vec3, c: Constants, dt_s: float) -> State:
    """Return the state after one step of `dt_s` with constant tau."""
    return normalised(rk4(_rate, _along, 0.0, x, dt_s, (tau, current, c)))


@entry("TUPLE13(TUPLE13, TUPLE6, TUPLE3, TUPLE21, float64, int64)")
def advance(
    x: State, tau: Numbers, current: Vec3, numbers: tuple[float, ...], dt_s: float, steps: int
) -> State:
    """
    Return the state after `steps` steps of `dt_s` with constant tau; `numbers` are the hull's `Constants`.
    """
    c = Constants(*numbers)
    for _ in range(steps):
        x = stepped(x, tau, current, c, dt_s)
    return x
