"""
The motion of a level vehicle, linear in twelve constants: M nu_r' + C(nu) nu_r + D(nu) nu_r = Y a.

    a = [m11 m22 m33 m44 | d_L1 .. d_L4 | d_Q1 .. d_Q4]        surge, sway, heave, yaw

This corresponds to thesis Eqs. (3.9) and (3.17)-(3.20) for the printed eight numbers, but in the body frame,
with the Coriolis terms and with linear drag.

Deviation: thesis (3.20) treats the drag of Table 3.1, which depends on the speed, as a constant parameter,
and (3.14)-(3.16) multiply it by the magnitude of the speed once more; here d_L and d_Q are two constants per
axis.
"""

from __future__ import annotations

Vec4 = tuple[float, float, float, float]
Vec12 = tuple[float, float, float, float, float, float, float, float, float, float, float, float]


def body_forces(a: tuple[float, ...], nu: Vec4, nu_r: Vec4, nu_r_rate: Vec4) -> Vec4:
    """
    Return Y a: the forces (N) and the yaw moment (N m) that the motion `nu_r` needs according to the
    estimates `a`.

    Parameters
    ----------
    a : (12,) tuple, or longer
        Masses (kg, kg m^2), linear damping (N s/m, N m s/rad), quadratic damping (N s^2/m^2, N m s^2/rad^2).
    nu, nu_r, nu_r_rate : (4,) tuples
        Velocity, virtual reference velocity (m/s, rad/s) and its rate (m/s^2, rad/s^2); body frame.

    """
    u, v, w, r = nu
    ur, vr, wr, rr = nu_r
    ax, ay, az, an = nu_r_rate
    m11, m22 = a[0], a[1]
    return (
        m11 * ax - m22 * v * rr + (a[4] + a[8] * abs(u)) * ur,
        m22 * ay + m11 * u * rr + (a[5] + a[9] * abs(v)) * vr,
        a[2] * az + (a[6] + a[10] * abs(w)) * wr,
        a[3] * an + m22 * v * ur - m11 * u * vr + (a[7] + a[11] * abs(r)) * rr,
    )


def transposed_times(nu: Vec4, nu_r: Vec4, nu_r_rate: Vec4, s: Vec4) -> Vec12:
    """Return Y^T s, the direction in which each of the twelve estimates acts on the error `s`."""
    u, v, w, r = nu
    ur, vr, wr, rr = nu_r
    ax, ay, az, an = nu_r_rate
    s1, s2, s3, s4 = s
    x, y, z, n = ur * s1, vr * s2, wr * s3, rr * s4
    return (
        ax * s1 + u * (rr * s2 - vr * s4),
        ay * s2 + v * (ur * s4 - rr * s1),
        az * s3,
        an * s4,
        x,
        y,
        z,
        n,
        abs(u) * x,
        abs(v) * y,
        abs(w) * z,
        abs(r) * n,
    )
