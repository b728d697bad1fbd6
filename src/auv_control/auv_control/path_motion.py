"""
A vehicle and its path at one instant, for adaptive tracking: errors, their sum s, virtual reference.

Four-vectors are in the order x, y, z, yaw (NED) or surge, sway, heave, yaw (body).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from auv_control.body_regressor import Vec4
from auv_control.controllers import MotionView
from auv_control.references import PathPoint
from auv_control.start_blend import blend, wrapped
from auv_core.geometry import heading_from_quaternion
from auv_core.integrate import State


class Motion(NamedTuple):
    """
    One instant: nu (body, or NED if the frame is flat), J by cosine and sine, path and errors (NED; m, rad
    and their rates).
    """

    nu: Vec4
    cosine: float
    sine: float
    target_rate: Vec4
    target_acceleration: Vec4
    error: Vec4
    error_rate: Vec4


def motion_of(view: MotionView, path: PathPoint, *, is_flat: bool, start: State, blend_s: float) -> Motion:
    """
    Return the motion of a vehicle and its path.

    Parameters
    ----------
    view : MotionView
        Own navigation and the time.
    path : PathPoint
        The point of the path at that time.
    is_flat : bool
        Whether J = I.
    start : tuple
        With a blend its start (s) and the offset eta(0) - eta_ref(0) there (m, rad; NED), else empty.
    blend_s : float
        Time in which the reference moves from the start to the path (s); 0: it is on the path at once.

    """
    px, py, pz = path.position
    vx, vy, vz = path.velocity
    ax, ay, az = path.acceleration
    pn, vn, an = path.heading_rad, path.heading_rate_radps, path.heading_acceleration_radps2
    if blend_s:
        start_s, *offsets = start
        ox, oy, oz, on = offsets
        b, b1, b2 = blend(view.t_s - start_s, blend_s)
        px, py, pz, pn = px + b * ox, py + b * oy, pz + b * oz, pn + b * on
        vx, vy, vz, vn = vx + b1 * ox, vy + b1 * oy, vz + b1 * oz, vn + b1 * on
        ax, ay, az, an = ax + b2 * ox, ay + b2 * oy, az + b2 * oz, an + b2 * on
    psi = heading_from_quaternion(view.nav.attitude)
    u, v, w, _, _, r = view.nav.nu
    c, s = (1.0, 0.0) if is_flat else (math.cos(psi), math.sin(psi))
    x, y, z = view.nav.position
    return Motion(
        nu=(u, v, w, r),
        cosine=c,
        sine=s,
        target_rate=(vx, vy, vz, vn),
        target_acceleration=(ax, ay, az, an),
        error=(x - px, y - py, z - pz, wrapped(psi - pn)),
        error_rate=(c * u - s * v - vx, s * u + c * v - vy, w - vz, r - vn),
    )


def composite_error(motion: Motion, error_rate_ps: Vec4) -> Vec4:
    """Return s = e' + LAM e (m/s, rad/s; NED), thesis Eq. (3.11)."""
    (ex, ey, ez, en), (rx, ry, rz, rn) = motion.error, motion.error_rate
    cx, cy, cz, cn = error_rate_ps
    return (rx + cx * ex, ry + cy * ey, rz + cz * ez, rn + cn * en)


def virtual_motion(motion: Motion, error_rate_ps: Vec4) -> tuple[Vec4, Vec4, Vec4]:
    """
    Return nu, nu_r = J^T (eta_d' - LAM e) and nu_r' (m/s, rad/s, their rates; body).

    Deviation: thesis (3.15) has J = I; here the rotation of the frame enters nu_r'.
    """
    cx, cy, cz, cn = error_rate_ps
    (ex, ey, ez, en), (rx, ry, rz, rn) = motion.error, motion.error_rate
    (vx, vy, vz, vn), (ax, ay, az, an) = motion.target_rate, motion.target_acceleration
    vx, vy, ax, ay = vx - cx * ex, vy - cy * ey, ax - cx * rx, ay - cy * ry
    c, s, r = motion.cosine, motion.sine, motion.nu[3]
    ur, vr = c * vx + s * vy, c * vy - s * vx
    return (
        motion.nu,
        (ur, vr, vz - cz * ez, vn - cn * en),
        (c * ax + s * ay + r * vr, c * ay - s * ax - r * ur, az - cz * rz, an - cn * rn),
    )
