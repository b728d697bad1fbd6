"""
The corrected law of chapter 3 and its plant over arrays: N vehicles at once, in continuous time.

The arithmetic is that of `auv_control.controllers.adaptive` (mode ``corrected``) and
`auv_core.models.four_dof` (frame ``body``); a test compares them. Vectors are (N, 4): x, y, z, yaw in NED, or
surge, sway, heave, yaw in the body.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from auv_control.controllers.adaptive import Params

Floats = NDArray[np.float64]

_P = Params()


@dataclass(frozen=True)
class Law:
    """
    Model, gains and plant.

    The defaults are thesis Table 3.1 and the gains of the corrected law. `estimates` are the first
    parameters of the law, `adaptation` their GAM; without adaptation the law is one with fixed parameters.
    """

    inertia: Floats = field(default_factory=lambda: np.array(_P.nominal_inertia))
    linear: Floats = field(default_factory=lambda: np.array(_P.nominal_linear_damping))
    quadratic: Floats = field(default_factory=lambda: np.array(_P.nominal_quadratic_damping))
    error_gain: Floats = field(default_factory=lambda: np.array(_P.error_gain))
    error_rate_ps: Floats = field(default_factory=lambda: np.array(_P.error_rate_ps))
    initial_ratio: float = 1.0
    adapts: bool = False

    @property
    def exact(self) -> Floats:
        """The twelve constants of the plant, in the order of the law's estimates."""
        return np.concatenate((self.inertia, self.linear, self.quadratic))

    @property
    def estimates(self) -> Floats:
        """The first estimates, (12,)."""
        return self.initial_ratio * self.exact

    @property
    def adaptation(self) -> Floats:
        """GAM, (12,); zeros without adaptation."""
        gains = (*_P.inertia_adaptation, *_P.linear_adaptation, *_P.quadratic_adaptation)
        return np.array(gains) if self.adapts else np.zeros(12)

    def boxed(self, estimates: Floats) -> Floats:
        """Return estimates in the box of the law."""
        low, high = _P.low_ratio * self.exact, _P.high_ratio * self.exact + _P.high_extra
        return np.clip(estimates, low, high)


def ned_from_body(psi: Floats, nu: Floats) -> Floats:
    """Return J nu, (N, 4)."""
    c, s = np.cos(psi), np.sin(psi)
    return np.stack((c * nu[:, 0] - s * nu[:, 1], s * nu[:, 0] + c * nu[:, 1], nu[:, 2], nu[:, 3]), axis=1)


def body_from_ned(psi: Floats, rates: Floats) -> Floats:
    """Return J^T of NED rates, (N, 4)."""
    return ned_from_body(-psi, rates)


def wrench(
    law: Law, eta: Floats, nu: Floats, wanted: tuple[Floats, Floats, Floats], estimates: Floats
) -> tuple[Floats, Floats]:
    """
    Return the forces of the law and Y^T s.

    Parameters
    ----------
    law : Law
        Gains.
    eta, nu : (N, 4) arrays
        Pose (m, rad; NED) and velocity (m/s, rad/s; body).
    wanted : three (N, 4) arrays
        Desired pose, its rate and its acceleration (NED).
    estimates : (N, 12) array
        Parameters of the law.

    Returns
    -------
    tau : (N, 4) array
        Forces (N) and yaw moment (N m; body).
    direction : (N, 12) array
        Y^T s, with which the estimates fall.

    """
    place, rate, acceleration = wanted
    psi = eta[:, 3]
    error, error_rate = eta - place, ned_from_body(psi, nu) - rate
    error[:, 3] = np.remainder(error[:, 3] + np.pi, 2.0 * np.pi) - np.pi
    nu_r = body_from_ned(psi, rate - law.error_rate_ps * error)
    nu_r_rate = body_from_ned(psi, acceleration - law.error_rate_ps * error_rate)
    r = nu[:, 3]
    nu_r_rate[:, 0] += r * nu_r[:, 1]
    nu_r_rate[:, 1] -= r * nu_r[:, 0]
    s = nu - nu_r
    m, linear, quadratic = estimates[:, :4], estimates[:, 4:8], estimates[:, 8:]
    tau = m * nu_r_rate + (linear + quadratic * np.abs(nu)) * nu_r - law.error_gain * s
    u, v, ur, vr, rr = nu[:, 0], nu[:, 1], nu_r[:, 0], nu_r[:, 1], nu_r[:, 3]
    tau[:, 0] -= m[:, 1] * v * rr
    tau[:, 1] += m[:, 0] * u * rr
    tau[:, 3] += m[:, 1] * v * ur - m[:, 0] * u * vr
    masses = nu_r_rate * s
    masses[:, 0] += u * (rr * s[:, 1] - vr * s[:, 3])
    masses[:, 1] += v * (ur * s[:, 3] - rr * s[:, 0])
    return tau, np.concatenate((masses, nu_r * s, np.abs(nu) * nu_r * s), axis=1)


def acceleration(law: Law, nu: Floats, tau: Floats) -> Floats:
    """Return nu' of the plant, (N, 4), for forces in the body frame."""
    m = law.inertia
    forces = tau - (law.linear + law.quadratic * np.abs(nu)) * nu
    u, v, r = nu[:, 0], nu[:, 1], nu[:, 3]
    forces[:, 0] += m[1] * v * r
    forces[:, 1] -= m[0] * u * r
    forces[:, 3] += (m[0] - m[1]) * u * v
    return forces / m
