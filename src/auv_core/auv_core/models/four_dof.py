"""
Level vehicle in surge, sway, heave and yaw, neutral and without roll and pitch (thesis Eqs. (2.10), (3.5),
(3.13)).

    m11 u' =  m22 v r - d(u) u + X         m33 w' = -d(w) w + Z
    m22 v' = -m11 u r - d(v) v + Y         m44 r' = (m11 - m22) u v - d(r) r + N

with d(a) = d_L + d_Q |a|, all relative to the water.  Chapter 2 is the same without heave.

Two parameters select the thesis's simulation instead of its printed equations:

* ``frame: flat`` takes J = I, so that eta' = nu: u, v, w are then the NED rates of the position, whatever the
  heading; ``body`` is eta' = J(psi) nu.
* ``drag: thesis`` is d(a) = d_L + d_Q a, (2.10) as printed. Below a = -d_L / d_Q it accelerates the vehicle
  instead of braking it, and a run may end without a finite solution; ``abs`` is the drag of a real hull.

Deviation: thesis (2.10) counts the drag among the Coriolis terms; here C only rotates momentum and does no
work, and D only removes energy (tests check both for `abs` and `body`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.drag import steady_speed_mps
from auv_core.geometry import Vec3, clipped, quaternion_from_heading
from auv_core.integrate import State, rk4_step
from auv_core.messages import Numbers, Vec6
from auv_core.models import ContinuousModel, Handling, hovering
from auv_core.params import param

Vec4 = tuple[float, float, float, float]


@dataclass(frozen=True)
class Params:
    """Numbers of a vehicle. Four-vectors are in the order surge, sway, heave, yaw."""

    inertia: Vec4 = param("mass (kg) and moment of inertia (kg m^2), including added mass", above=0.0)
    linear_damping: Vec4 = param("linear damping d_L (N s/m, N m s/rad)", minimum=0.0)
    quadratic_damping: Vec4 = param("quadratic damping d_Q (N s^2/m^2, N m s^2/rad^2)", minimum=0.0)
    coriolis: bool = param("whether surge, sway and yaw are coupled by C(nu)", default=True)
    frame: str = param(
        "frame of nu: body, or NED as the thesis simulated (flat)", default="body", choices=("body", "flat")
    )
    drag: str = param(
        "quadratic drag with |a| a (abs), or with a^2 as printed (thesis)",
        default="abs",
        choices=("abs", "thesis"),
    )
    max_force_n: float | None = param("actuator limit per axis (N); null: none", default=None, above=0.0)
    max_moment_nm: float | None = param("limit of the yaw moment (N m); null: none", default=None, above=0.0)
    hull_radius_m: float = param("radius of the sphere around the hull (m)", default=0.3, above=0.0)


class Model(ContinuousModel):
    """A vehicle that takes a wrench, of which only X, Y, Z and N act; integrated by RK4."""

    command = "wrench"

    def __init__(self, params: Params) -> None:
        self.params = params
        self._is_flat = params.frame == "flat"
        self._is_printed_drag = params.drag == "thesis"
        self._max_force_n = math.inf if params.max_force_n is None else params.max_force_n
        self._max_moment_nm = math.inf if params.max_moment_nm is None else params.max_moment_nm

    @property
    def handling(self) -> Handling:
        """It hovers."""
        return hovering(self.params.hull_radius_m)

    @property
    def top_speed_mps(self) -> float:
        """
        Speed that the weakest of the three forces can hold against the drag (m/s), infinite without limits.
        """
        return self.speed_held_mps(math.inf)

    def speed_held_mps(self, max_force_n: float) -> float:
        """Return the same for a controller with this limit along each axis (N)."""
        p = self.params
        return min(
            steady_speed_mps(linear, quadratic, min(self._max_force_n, max_force_n))
            for linear, quadratic in zip(p.linear_damping[:3], p.quadratic_damping[:3], strict=True)
        )

    def initial_state(self, position: Vec3, heading_rad: float, speed_mps: float = 0.0) -> State:
        """Return the state of a vehicle that runs ahead at a speed over ground (m/s)."""
        return (*position, *quaternion_from_heading(heading_rad), speed_mps, 0.0, 0.0, 0.0, 0.0, 0.0)

    def limited_command(self, tau: Numbers) -> Numbers:
        """
        Return the wrench of the actuators for a command: clipped per axis, without roll and pitch moment.
        """
        f, m = self._max_force_n, self._max_moment_nm
        return (clipped(tau[0], f), clipped(tau[1], f), clipped(tau[2], f), 0.0, 0.0, clipped(tau[5], m))

    def kinetic_energy(self, nu: Vec6) -> float:
        """Return nu^T M nu / 2 (J)."""
        a, b, c, d = self.params.inertia
        return 0.5 * (a * nu[0] ** 2 + b * nu[1] ** 2 + c * nu[2] ** 2 + d * nu[5] ** 2)

    def derivative(self, state: State, tau: Numbers, current: Vec3) -> State:
        """
        Return the rate of change of the 13 floats of a state.

        Parameters
        ----------
        state : (13,) tuple
            NED position (m), quaternion body to NED (w, x, y, z; level), nu (m/s, rad/s).
        tau : (6,) tuple
            Wrench of the actuators (N, N m; body, or NED if the frame is flat).
        current : (3,) tuple
            Velocity of the water (m/s; NED).

        """
        qw, qz = state[3], state[6]
        u, v, w, r = state[7], state[8], state[9], state[12]
        cosine, sine = (1.0, 0.0) if self._is_flat else (qw * qw - qz * qz, 2.0 * qw * qz)
        cu, cv = cosine * current[0] + sine * current[1], cosine * current[1] - sine * current[0]
        turning = 0.0 if self._is_flat else r
        x, y, z, n = self._accelerations((u - cu, v - cv, w - current[2], r), tau)
        return (
            cosine * u - sine * v,
            sine * u + cosine * v,
            w,
            -0.5 * qz * r,
            0.0,
            0.0,
            0.5 * qw * r,
            x + turning * cv,
            y - turning * cu,
            z,
            0.0,
            0.0,
            n,
        )

    def _accelerations(self, water: Vec4, tau: Numbers) -> Vec4:
        """Return the rates of nu relative to the water, including the rotation of the frame."""
        p = self.params
        m11, m22, m33, m44 = p.inertia
        u, v, w, r = water
        (lu, lv, lw, lr), (qu, qv, qw, qr) = p.linear_damping, p.quadratic_damping
        su, sv, sw, sr = water if self._is_printed_drag else (abs(u), abs(v), abs(w), abs(r))
        turn = 1.0 if p.coriolis else 0.0
        return (
            (tau[0] + turn * m22 * v * r - (lu + qu * su) * u) / m11,
            (tau[1] - turn * m11 * u * r - (lv + qv * sv) * v) / m22,
            (tau[2] - (lw + qw * sw) * w) / m33,
            (tau[5] + turn * (m11 - m22) * u * v - (lr + qr * sr) * r) / m44,
        )

    def normalised(self, state: State) -> State:
        """Return the state with an attitude quaternion of length 1."""
        norm = math.hypot(state[3], state[6])
        return (*state[:3], state[3] / norm, 0.0, 0.0, state[6] / norm, *state[7:])

    def step(self, state: State, command: Numbers, current: Vec3, dt_s: float, steps: int = 1) -> State:
        """Return the state after `steps` steps of `dt_s`, the wrench `command` held."""
        for _ in range(steps):
            after = rk4_step(lambda _t_s, x: self.derivative(x, command, current), 0.0, state, dt_s)
            state = self.normalised(after)
        return state
