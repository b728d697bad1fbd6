"""Forces that depend on the motion: momentum, Coriolis force and damping."""

from __future__ import annotations

from typing import NamedTuple

from auv_core.compiled import inlined, record
from auv_core.geometry import Vec3


@record(", ".join(21 * ["float64"]))
class Constants(NamedTuple):
    """
    The constants of a hull for `derivative`.

    surge_kg, ..., yaw_kgm2: mass and inertia, including added mass.  static_moment_kgm: m z_G, as in M
    and C.  linear_surge, ..., quadratic_yaw: damping (N s/m, N m s/rad; N s^2/m^2, N m s^2/rad^2).
    net_weight_n: W - B.  righting_nm: z_G W.
    """

    surge_kg: float
    sway_kg: float
    heave_kg: float
    roll_kgm2: float
    pitch_kgm2: float
    yaw_kgm2: float
    static_moment_kgm: float
    linear_surge: float
    linear_sway: float
    linear_heave: float
    linear_roll: float
    linear_pitch: float
    linear_yaw: float
    quadratic_surge: float
    quadratic_sway: float
    quadratic_heave: float
    quadratic_roll: float
    quadratic_pitch: float
    quadratic_yaw: float
    net_weight_n: float
    righting_nm: float


@inlined
def momentum(velocity: Vec3, rates: Vec3, c: Constants) -> tuple[Vec3, Vec3]:
    """
    Return M nu: linear momentum (kg m/s) and angular momentum (kg m^2/s), body frame, added mass included.
    """
    u, v, w = velocity
    p, q, r = rates
    s = c.static_moment_kgm
    return (
        (c.surge_kg * u + s * q, c.sway_kg * v - s * p, c.heave_kg * w),
        (c.roll_kgm2 * p - s * v, c.pitch_kgm2 * q + s * u, c.yaw_kgm2 * r),
    )


@inlined
def turned_momentum(velocity: Vec3, rates: Vec3, linear: Vec3, angular: Vec3) -> tuple[Vec3, Vec3]:
    """
    Return C(nu) nu as force (N) and moment (N m), body frame: Kirchhoff's equations, Fossen (2021) Eq.
    (3.60), for a linear (kg m/s) and an angular momentum (kg m^2/s).

    If the momentum is M nu, then C is skew-symmetric, so nu . C(nu) nu == 0: it does no work.
    """
    (lx, ly, lz), (hx, hy, hz) = linear, angular
    u, v, w = velocity
    p, q, r = rates
    force = (q * lz - r * ly, r * lx - p * lz, p * ly - q * lx)
    moment = (
        v * lz - w * ly + q * hz - r * hy,
        w * lx - u * lz + r * hx - p * hz,
        u * ly - v * lx + p * hy - q * hx,
    )
    return force, moment


@inlined
def coriolis_force(velocity: Vec3, rates: Vec3, c: Constants) -> tuple[Vec3, Vec3]:
    """Return C(nu) nu as force (N) and moment (N m), body frame; see `turned_momentum`."""
    linear, angular = momentum(velocity, rates, c)
    return turned_momentum(velocity, rates, linear, angular)


@inlined
def damping_force(velocity: Vec3, rates: Vec3, c: Constants) -> tuple[Vec3, Vec3]:
    """
    Return D(nu) nu as force (N) and moment (N m), body frame; nu . D(nu) nu >= 0: it only removes energy.
    """
    u, v, w = velocity
    p, q, r = rates
    return (
        (
            (c.linear_surge + c.quadratic_surge * abs(u)) * u,
            (c.linear_sway + c.quadratic_sway * abs(v)) * v,
            (c.linear_heave + c.quadratic_heave * abs(w)) * w,
        ),
        (
            (c.linear_roll + c.quadratic_roll * abs(p)) * p,
            (c.linear_pitch + c.quadratic_pitch * abs(q)) * q,
            (c.linear_yaw + c.quadratic_yaw * abs(r)) * r,
        ),
    )
