"""
Inner loop of a fully actuated vehicle: PI on the velocity over ground, PD on the attitude.

A flocking law gives a velocity, and this loop makes the hull follow it. The integral state, in NED,
compensates drag and current. It is frozen while an actuator that it drives is at its limit, so that it does
not wind up. In continuous time it is integrated with the other states.

With mass m (added mass included), gains K_p and K_i, the transfer function from commanded to true velocity is
(K_p s + K_i) / (m s^2 + K_p s + K_i): bandwidth about K_p / m, damping K_p / (2 sqrt(m K_i)).
"""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import NamedTuple

from auv_control.attitude import attitude_moment
from auv_control.controllers import ContinuousVelocityController, VelocityReference
from auv_core.compiled import entry, fastest, inlined, record
from auv_core.geometry import (
    Quat,
    Vec3,
    body_to_ned,
    clipped,
    ned_to_body,
    quaternion_from_heading,
)
from auv_core.messages import Vec6, VehicleState, Wrench
from auv_core.params import param


@record(", ".join(6 * ["float64"]))
class Gains(NamedTuple):
    """`Params` as compiled functions take them."""

    velocity_nspm: float
    integral_npm: float
    attitude_nm: float
    rate_nms: float
    max_force_n: float
    max_moment_nm: float


@dataclass(frozen=True)
class Params:
    """Gains, and the actuator limits that the controller assumes."""

    velocity_gain_nspm: float = param("force per velocity error K_p (N s/m)", default=300.0, above=0.0)
    integral_gain_npm: float = param(
        "force per integrated velocity error K_i (N/m)", default=75.0, minimum=0.0
    )
    attitude_gain_nm: float = param("moment per attitude error (N m/rad)", default=20.0, minimum=0.0)
    rate_gain_nms: float = param("moment per body rate (N m s/rad)", default=25.0, minimum=0.0)
    max_force_n: float = param("force limit per body axis (N)", default=150.0, above=0.0)
    max_moment_nm: float = param("moment limit per body axis (N m)", default=50.0, above=0.0)

    @property
    def gains(self) -> Gains:
        """All of these parameters."""
        return Gains(*map(float, astuple(self)))


@entry("Tuple((TUPLE6, TUPLE3))(TUPLE4, TUPLE6, TUPLE3, TUPLE3, TUPLE4, Gains)")
@inlined
def control(
    attitude: Quat, nu: Vec6, integral: Vec3, wanted: Vec3, facing: Quat, gains: Gains
) -> tuple[Vec6, Vec3]:
    """
    Return the wrench (N, N m; body) and the rate of the integral (m/s; NED).

    Parameters
    ----------
    attitude, facing : (4,) tuple
        Attitude of the vehicle and attitude to reach (quaternions, body to NED).
    nu : (6,) tuple
        Body velocities (m/s, rad/s).
    integral, wanted : (3,) tuple
        Integrated velocity error (m; NED) and commanded velocity over ground (m/s; NED).
    gains : Gains
        From `Params.gains`.

    """
    ahead = ned_to_body(attitude, wanted)
    error = (ahead[0] - nu[0], ahead[1] - nu[1], ahead[2] - nu[2])
    held = ned_to_body(attitude, integral)
    ax = gains.velocity_nspm * error[0] + gains.integral_npm * held[0]
    ay = gains.velocity_nspm * error[1] + gains.integral_npm * held[1]
    az = gains.velocity_nspm * error[2] + gains.integral_npm * held[2]
    most_n = gains.max_force_n
    fx, fy, fz = clipped(ax, most_n), clipped(ay, most_n), clipped(az, most_n)
    growth = (0.0, 0.0, 0.0)
    if fx == ax and fy == ay and fz == az:
        growth = body_to_ned(attitude, error)
    mx, my, mz = attitude_moment(
        attitude, (nu[3], nu[4], nu[5]), facing, gains.attitude_nm, gains.rate_nms, gains.max_moment_nm
    )
    return (fx, fy, fz, mx, my, mz), growth


@entry("Tuple((TUPLE6, TUPLE3))(TUPLE4, TUPLE6, TUPLE3, TUPLE3, float64, float64, TUPLE6)")
def stepped(
    attitude: Quat, nu: Vec6, integral: Vec3, wanted: Vec3, heading_rad: float, period_s: float, numbers: Vec6
) -> tuple[Vec6, Vec3]:
    """
    Return the wrench (N, N m; body) of a control period, and the integral (m; NED) after it; `numbers` are
    `Gains`.
    """
    gains, facing = Gains(*numbers), quaternion_from_heading(heading_rad)
    tau, growth = control(attitude, nu, integral, wanted, facing, gains)
    return tau, (
        integral[0] + period_s * growth[0],
        integral[1] + period_s * growth[1],
        integral[2] + period_s * growth[2],
    )


class Controller(ContinuousVelocityController):
    """PI on velocity, PD on attitude; the heading is held and roll and pitch are brought to zero."""

    command = "wrench"
    follows = "velocity"

    def __init__(self, params: Params, period_s: float) -> None:
        self._gains = params.gains
        self._numbers: Vec6 = (*params.gains,)
        self._stepped = fastest(stepped)
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
        tau, self._integral = self._stepped(
            nav.attitude,
            nav.nu,
            self._integral,
            reference.velocity,
            reference.heading_rad,
            self._period_s,
            self._numbers,
        )
        return Wrench(tau)

    def evaluate(
        self, attitude: Quat, nu: Vec6, integral: Vec3, reference: VelocityReference
    ) -> tuple[Vec6, Vec3]:
        """Return wrench (N, N m; body) and rate of the integral (m/s; NED), both at one instant."""
        facing = quaternion_from_heading(reference.heading_rad)
        return fastest(control)(attitude, nu, integral, reference.velocity, facing, self._gains)
