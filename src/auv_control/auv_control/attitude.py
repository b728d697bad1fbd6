"""Attitude control of a hull: PD on the quaternion error, for controllers that follow a velocity."""

from __future__ import annotations

from auv_core.compiled import inlined
from auv_core.geometry import Quat, Vec3, clipped, quaternion_product


@inlined
def attitude_moment(
    attitude: Quat, rates: Vec3, facing: Quat, attitude_nm: float, rate_nms: float, max_moment_nm: float
) -> Vec3:
    """
    Return the moment that turns a hull to an attitude (N m; body), limited along each axis.

    Parameters
    ----------
    attitude, facing : (4,) tuple
        Attitude of the vehicle and attitude to reach (quaternions, body to NED).
    rates : (3,) tuple
        Angular velocity (rad/s; body).
    attitude_nm, rate_nms, max_moment_nm : float
        Moment per attitude error (N m/rad), per rate (N m s/rad), and its limit (N m).

    """
    w, x, y, z = attitude
    turn = quaternion_product((w, -x, -y, -z), facing)
    twice = 2.0 * attitude_nm if turn[0] >= 0.0 else -2.0 * attitude_nm
    return (
        clipped(twice * turn[1] - rate_nms * rates[0], max_moment_nm),
        clipped(twice * turn[2] - rate_nms * rates[1], max_moment_nm),
        clipped(twice * turn[3] - rate_nms * rates[2], max_moment_nm),
    )
