"""
The measurement model of a sonar contact: range, bearing and elevation in the body frame (FRD).

    h(r) = (|r|, atan2(y, x), atan2(-z, hypot(x, y))),  r = (x, y, z) the other hull in the own body frame.

A contact is much more accurate than a prediction after a long wait for a packet, or with a drifted
navigation. Therefore the model is linearised at the point that the contact itself gives, r* = h^-1(z), to
which an iterated extended Kalman filter converges, and not at the prediction: then h(r) ~ z + H (r - r*), the
residual is -H (r - r*) for any error of the prediction, and no angle has to be wrapped.

Source: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), sections
10.4.3 (converted measurements) and 10.5.2 (iterated filter).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from auv_core.geometry import Vec3, body_to_ned
from auv_core.messages import SonarContact, VehicleState

Matrix = NDArray[np.float64]

_SMALLEST_LEVEL_RATIO = 0.02
_SMALLEST_RANGE_M = 1e-3
_NO_LEVEL_M = 1e-200
_LARGEST_RANGE_M = 1e5


@dataclass(frozen=True, slots=True)
class Sighting:
    """
    A contact in the frame of the own navigation, ready for a filter.

    Attributes
    ----------
    time_s : float
        Time of the tick (s).
    point : (3,) array
        Position of the other hull from this contact alone (m; NED).
    jacobian : (3, 3) array
        H: derivative of (range, bearing, elevation) by that point.
    noise : (3, 3) array
        R: covariance of (range, bearing, elevation) (m^2, rad^2, rad^2).
    covariance : (3, 3) array
        The same noise as covariance of the point, H^-1 R H^-T (m^2; NED).
    own : (3,) array
        Position of the own navigation (m; NED).
    to_body : (3, 3) array
        Rotation from NED to the own body frame.

    """

    time_s: float
    point: Matrix
    jacobian: Matrix
    noise: Matrix
    covariance: Matrix
    own: Matrix
    to_body: Matrix

    def beside(self, point: Matrix) -> Matrix:
        """Return h of another point (m; NED) minus the contact (m, rad, rad), the bearing within a turn."""
        there, here = (contact_of(_vector(self.to_body @ (each - self.own))) for each in (point, self.point))
        return np.array(
            (
                there.range_m - here.range_m,
                math.remainder(there.bearing_rad - here.bearing_rad, 2.0 * math.pi),
                there.elevation_rad - here.elevation_rad,
            )
        )


def is_contact(contact: SonarContact) -> bool:
    """Return whether a contact is plausible: range, bearing within one turn, elevation."""
    return (
        0.0 < contact.range_m <= _LARGEST_RANGE_M
        and -2.0 * math.pi <= contact.bearing_rad <= 2.0 * math.pi
        and -0.5 * math.pi <= contact.elevation_rad <= 0.5 * math.pi
    )


def contact_of(relative: Vec3) -> SonarContact:
    """Return h: the contact of a hull at `relative` (m; body FRD)."""
    x, y, z = relative
    level_m = math.hypot(x, y)
    return SonarContact(math.hypot(level_m, z), math.atan2(y, x), math.atan2(-z, level_m))


def relative_of(contact: SonarContact) -> Vec3:
    """Return h^-1: the position of the hull of a contact (m; body FRD)."""
    level_m = contact.range_m * math.cos(contact.elevation_rad)
    return (
        level_m * math.cos(contact.bearing_rad),
        level_m * math.sin(contact.bearing_rad),
        -contact.range_m * math.sin(contact.elevation_rad),
    )


def contact_jacobian(relative: Vec3) -> Matrix:
    """
    Return the derivative (3, 3) of `contact_of` by `relative`.

    There is no bearing straight above or below, and no direction at zero distance: both distances have a
    lower bound.
    """
    (x, y, z), level_m, range_m = _kept_apart(relative)
    square_m2 = range_m * range_m
    return np.array(
        (
            (x / range_m, y / range_m, z / range_m),
            (-y / (level_m * level_m), x / (level_m * level_m), 0.0),
            (z * x / (square_m2 * level_m), z * y / (square_m2 * level_m), -level_m / square_m2),
        )
    )


def point_jacobian(relative: Vec3) -> Matrix:
    """Return the derivative (3, 3) of `relative_of` by the contact, the inverse of `contact_jacobian`."""
    (x, y, z), level_m, range_m = _kept_apart(relative)
    return np.array(
        (
            (x / range_m, -y, z * x / level_m),
            (y / range_m, x, z * y / level_m),
            (z / range_m, 0.0, -level_m),
        )
    )


def _kept_apart(relative: Vec3) -> tuple[Vec3, float, float]:
    """Return a point near `relative` with its level distance and its range (m), where angles are defined."""
    x, y, z = relative
    level_m, range_m = math.hypot(x, y), math.sqrt(x * x + y * y + z * z)
    least_m = _SMALLEST_LEVEL_RATIO * max(range_m, _SMALLEST_RANGE_M)
    if level_m < least_m:
        x, y = (x / level_m * least_m, y / level_m * least_m) if level_m > _NO_LEVEL_M else (least_m, 0.0)
        level_m = least_m
        range_m = math.hypot(level_m, z)
    return (x, y, z), level_m, range_m


def sighting(
    t_s: float, nav: VehicleState, contact: SonarContact, range_sd_m: float, angle_sd_rad: float
) -> Sighting:
    """
    Return a contact relative to the own navigation's pose.

    An error of the own heading rotates the contact about the vertical, which is an error of the bearing; its
    variance is added to the sonar's.

    Parameters
    ----------
    t_s : float
        Time of the contact (s).
    nav : VehicleState
        The own navigation at that time.
    contact : SonarContact
        The sonar contact.
    range_sd_m, angle_sd_rad : float
        The sonar's noise: range (m), bearing and elevation (rad).

    """
    relative = relative_of(contact)
    q = nav.attitude
    R_ned_body = np.array(
        (body_to_ned(q, (1.0, 0.0, 0.0)), body_to_ned(q, (0.0, 1.0, 0.0)), body_to_ned(q, (0.0, 0.0, 1.0)))
    ).T
    H = contact_jacobian(relative) @ R_ned_body.T
    back = R_ned_body @ point_jacobian(relative)
    angle_rad2 = angle_sd_rad * angle_sd_rad
    noise = np.diag(
        (range_sd_m * range_sd_m, angle_rad2 + nav.heading_sd_rad * nav.heading_sd_rad, angle_rad2)
    )
    own = np.array(nav.position)
    point = own + R_ned_body @ np.array(relative)
    return Sighting(t_s, point, H, noise, back @ noise @ back.T, own, R_ned_body.T)


def _vector(numbers: Matrix) -> Vec3:
    x, y, z = numbers.tolist()
    return (x, y, z)
