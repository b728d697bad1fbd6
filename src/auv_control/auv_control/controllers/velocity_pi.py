"""
Inner loop of a fully actuated vehicle: PI on the velocity over ground, PD on the attitude.

A flocking law gives a velocity; this loop makes the hull have it.  The integral, kept in NED, carries what
the model does not say: drag and the current.  It stops while an actuator that it drives is at its limit, so
that it does not wind up.

With mass m (added mass included), gains K_p and K_i, the loop from asked to true velocity is
(K_p s + K_i) / (m s^2 + K_p s + K_i): bandwidth about K_p / m, damping K_p / (2 sqrt(m K_i)).
"""

from __future__ import annotations

from dataclasses import dataclass

from auv_control.controllers import VelocityReference
from auv_core.geometry import Vec3, body_to_ned, ned_to_body, quaternion_from_heading, quaternion_product
from auv_core.messages import Vec6, VehicleState, Wrench
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """Gains and the limits that the controller believes its actuators to have."""

    velocity_gain_nspm: float = param("force per velocity error K_p (N s/m)", default=300.0, above=0.0)
    integral_gain_npm: float = param(
        "force per integrated velocity error K_i (N/m)", default=75.0, minimum=0.0
    )
    attitude_gain_nm: float = param("moment per attitude error (N m/rad)", default=20.0, minimum=0.0)
    rate_gain_nms: float = param("moment per body rate (N m s/rad)", default=25.0, minimum=0.0)
    max_force_n: float = param("force limit per body axis (N)", default=150.0, above=0.0)
    max_moment_nm: float = param("moment limit per body axis (N m)", default=50.0, above=0.0)


class Controller:
    """PI on velocity, PD on attitude; the heading is held and roll and pitch are brought to zero."""

    command = "wrench"
    follows = "velocity"

    def __init__(self, params: Params, period_s: float) -> None:
        self._params = params
        self._period_s = period_s
        self._integral: Vec3 = (0.0, 0.0, 0.0)

    def step(self, nav: VehicleState, reference: VelocityReference) -> Wrench:
        """
        Return the wrench (N, N m; body) for one control period.

        Parameters
        ----------
        nav : VehicleState
            The vehicle's own navigation.
        reference : VelocityReference
            Velocity over ground (m/s; NED) and heading (rad).

        """
        p = self._params
        wanted = ned_to_body(nav.attitude, reference.velocity)
        error = (wanted[0] - nav.nu[0], wanted[1] - nav.nu[1], wanted[2] - nav.nu[2])
        held = ned_to_body(nav.attitude, self._integral)
        asked = tuple(
            [p.velocity_gain_nspm * e + p.integral_gain_npm * i for e, i in zip(error, held, strict=True)]
        )
        fx, fy, fz = (_clipped(value, p.max_force_n) for value in asked)
        if (fx, fy, fz) == asked:
            growth = body_to_ned(nav.attitude, error)
            self._integral = (
                self._integral[0] + self._period_s * growth[0],
                self._integral[1] + self._period_s * growth[1],
                self._integral[2] + self._period_s * growth[2],
            )
        mx, my, mz = self._moment(nav, reference.heading_rad)
        tau: Vec6 = (fx, fy, fz, mx, my, mz)
        return Wrench(tau)

    def _moment(self, nav: VehicleState, heading_rad: float) -> Vec3:
        p = self._params
        w, x, y, z = nav.attitude
        error = quaternion_product((w, -x, -y, -z), quaternion_from_heading(heading_rad))
        twice = 2.0 if error[0] >= 0.0 else -2.0
        mx, my, mz = (
            _clipped(p.attitude_gain_nm * twice * e - p.rate_gain_nms * rate, p.max_moment_nm)
            for e, rate in zip(error[1:], nav.nu[3:], strict=True)
        )
        return (mx, my, mz)


def _clipped(value: float, limit: float) -> float:
    return limit if value > limit else max(value, -limit)
