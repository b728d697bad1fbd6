"""
What the model-based controllers under a flocking law share: the loop around a force per axis.

The velocity error is integrated in NED, and the integral is frozen while a force is at its limit. The
attitude is that of `attitude_moment`. The model's drag comes from `drag_factor`.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

from auv_control.attitude import attitude_moment
from auv_control.controllers import ContinuousVelocityController, VelocityReference
from auv_core.geometry import Quat, Vec3, body_to_ned, clipped, ned_to_body, quaternion_from_heading
from auv_core.messages import Vec6, VehicleState, Wrench
from auv_core.params import param


@dataclass(frozen=True)
class LoopParams:
    """Model of the drag, attitude gains and limits; the hull is ODIN's."""

    linear_damping: Vec3 = param("d_L of the model (N s/m)", default=(0.0, 0.0, 0.0), minimum=0.0)
    quadratic_damping: Vec3 = param("d_Q of the model (N s^2/m^2)", default=(48.0, 48.0, 48.0), minimum=0.0)
    attitude_gain_nm: float = param("moment per attitude error (N m/rad)", default=20.0, minimum=0.0)
    rate_gain_nms: float = param("moment per body rate (N m s/rad)", default=25.0, minimum=0.0)
    max_force_n: float = param("force limit per body axis (N)", default=150.0, above=0.0)
    max_moment_nm: float = param("moment limit per body axis (N m)", default=50.0, above=0.0)

    def drag_factor(self, axis: int, speed_mps: float) -> float:
        """Return d_L + d_Q |speed| of surge, sway or heave (N s/m)."""
        return self.linear_damping[axis] + self.quadratic_damping[axis] * abs(speed_mps)


class VelocityLoop(ContinuousVelocityController):
    """A loop whose force along an axis depends on that axis only; its state is the integral (m; NED)."""

    command = "wrench"
    follows = "velocity"

    def __init__(self, params: LoopParams, period_s: float) -> None:
        self._loop = params
        self._period_s = period_s
        self._integral: Vec3 = (0.0, 0.0, 0.0)

    @abstractmethod
    def force(self, axis: int, actual_mps: float, wanted_mps: float, held_m: float) -> float:
        """
        Return the force along one axis before its limit (N; body).

        Parameters
        ----------
        axis : int
            0 to 2: surge, sway, heave.
        actual_mps, wanted_mps : float
            Velocity and commanded velocity (m/s; body).
        held_m : float
            The integral along this axis (m; body).

        """

    def step(self, nav: VehicleState, reference: VelocityReference) -> Wrench:
        """Return the wrench (N, N m; body) for one control period."""
        tau, (dx, dy, dz) = self.evaluate(nav.attitude, nav.nu, self._integral, reference)
        (x, y, z), h = self._integral, self._period_s
        self._integral = (x + h * dx, y + h * dy, z + h * dz)
        return Wrench(tau)

    def evaluate(
        self, attitude: Quat, nu: Vec6, integral: Vec3, reference: VelocityReference
    ) -> tuple[Vec6, Vec3]:
        """Return wrench (N, N m; body) and rate of the integral (m/s; NED), both at one instant."""
        p = self._loop
        wanted, held = ned_to_body(attitude, reference.velocity), ned_to_body(attitude, integral)
        asked = [self.force(axis, nu[axis], wanted[axis], held[axis]) for axis in range(3)]
        fx, fy, fz = [clipped(force, p.max_force_n) for force in asked]
        rate = (0.0, 0.0, 0.0)
        if [fx, fy, fz] == asked:
            rate = body_to_ned(attitude, (wanted[0] - nu[0], wanted[1] - nu[1], wanted[2] - nu[2]))
        facing = quaternion_from_heading(reference.heading_rad)
        mx, my, mz = attitude_moment(
            attitude, (nu[3], nu[4], nu[5]), facing, p.attitude_gain_nm, p.rate_gain_nms, p.max_moment_nm
        )
        return (fx, fy, fz, mx, my, mz), rate
