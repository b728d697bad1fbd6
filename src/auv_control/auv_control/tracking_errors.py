"""
Errors of a vehicle on a path in the horizontal plane, thesis Eqs. (2.13)-(2.16), in one of three frames.

All errors are reference minus actual.  Three-vectors are in the order surge, sway, yaw.

* ``body``: eta_e = J^T (eta_r - eta), nu_r = J^T eta_r', nu_r' = J^T eta_r'' + r [v_r, -u_r, 0]. Forces
  along the hull's axes need these.
* ``flat``: J = I, for a plant whose nu are the NED rates; the thesis's simulations use it.
* ``mixed``: the NED errors of ``flat`` with the body velocity of the plant, literally as printed. It mixes
  the frames: a law with it does not converge unless the heading stays near north.

Deviation: thesis (2.15) uses eta_r' as nu_r without J^T, so that nu_e mixes body and NED rates.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from auv_control.controllers import MotionView
from auv_core.geometry import Vec3, heading_from_quaternion

FRAMES = ("flat", "body", "mixed")


class TrackingErrors(NamedTuple):
    """
    Errors of a vehicle relative to its path point, in the axes of a frame.

    Attributes
    ----------
    pose : (3,) tuple
        eta_e: along the two axes (m) and in heading (rad, in [-pi, pi]).
    velocity : (3,) tuple
        nu_e = nu_r - nu (m/s, m/s, rad/s).
    reference : (3,) tuple
        nu_r (m/s, m/s, rad/s).
    reference_rate : (3,) tuple
        nu_r' (m/s^2, m/s^2, rad/s^2).

    """

    pose: Vec3
    velocity: Vec3
    reference: Vec3
    reference_rate: Vec3


def tracking_errors(view: MotionView, frame: str) -> TrackingErrors:
    """
    Return eta_e, nu_e, nu_r and nu_r' of one instant.

    Parameters
    ----------
    view : MotionView
        The vehicle's own navigation and its path point.
    frame : str
        'body', 'flat' or 'mixed'.

    """
    nav, path = view.nav, view.path
    if path is None:
        raise ValueError("view: has no path point; a law that follows a path needs one")
    heading_rad = heading_from_quaternion(nav.attitude)
    nu = nav.nu
    r = nu[5]
    ex, ey = path.position[0] - nav.position[0], path.position[1] - nav.position[1]
    ur, vr = path.velocity[0], path.velocity[1]
    ar, br = path.acceleration[0], path.acceleration[1]
    if frame == "body":
        cosine, sine = math.cos(heading_rad), math.sin(heading_rad)
        ex, ey = cosine * ex + sine * ey, cosine * ey - sine * ex
        ur, vr = cosine * ur + sine * vr, cosine * vr - sine * ur
        ar, br = cosine * ar + sine * br + r * vr, cosine * br - sine * ar - r * ur
    psi_e = math.remainder(path.heading_rad - heading_rad, 2.0 * math.pi)
    rr = path.heading_rate_radps
    return TrackingErrors(
        (ex, ey, psi_e),
        (ur - nu[0], vr - nu[1], rr - r),
        (ur, vr, rr),
        (ar, br, path.heading_acceleration_radps2),
    )


def ned_force_in_frame(view: MotionView, force: tuple[float, float], frame: str) -> tuple[float, float]:
    """
    Return a horizontal NED force (N) along the axes of `frame`: rotated by J^T in 'body', otherwise
    unchanged.
    """
    if frame != "body":
        return force
    heading_rad = heading_from_quaternion(view.nav.attitude)
    cosine, sine = math.cos(heading_rad), math.sin(heading_rad)
    return cosine * force[0] + sine * force[1], cosine * force[1] - sine * force[0]
