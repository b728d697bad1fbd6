"""
Rigid body in six degrees of freedom, relative to the water: Fossen's marine craft model.

    M nu_r_dot + C(nu_r) nu_r + D(nu_r) nu_r + g(eta) = tau,      eta_dot = J(eta) nu,     nu_r = nu - J^-1
    nu_c

(Fossen 2021, Handbook of Marine Craft Hydrodynamics and Motion Control, ch. 6-8) for hulls with three
planes of symmetry, the origin at the hull's centre (= centre of buoyancy) and the centre of gravity z_G
below it. Added mass and damping are diagonal, z_G couples surge with pitch and sway with roll.  Attitude is
a unit quaternion, so that there is no singular pitch angle; the matrix of Euler rates, thesis Eqs.
(2.6)-(2.7), which is singular at a pitch of 90 degrees, is nowhere used.

``cog_couples: false`` leaves z_G out of M and C, but not out of g: this is the vehicle of thesis Eqs. (4.2)
and (4.14), whose Table 4.1 has a mass and no coupling. Deviation: the weight of this hull does not act at its
mass.

Roll and pitch are states, stabilised by the righting moment z_G W and by the controller. At the
accelerations of a flock (a few cm/s^2) they stay within a degree, but a larger force makes the hull pitch,
and a law should be tested with that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.compiled import entry, fastest, inlined
from auv_core.drag import steady_speed_mps
from auv_core.geometry import Quat, Vec3, clipped, quaternion_from_heading
from auv_core.integrate import State, rk4
from auv_core.messages import Numbers, Vec6
from auv_core.models import ContinuousModel, Handling, hovering
from auv_core.models._hull_forces import Constants as Constants
from auv_core.models._hull_forces import coriolis_force, damping_force, momentum
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """Numbers of a vehicle. Six-vectors are in the order surge, sway, heave, roll, pitch, yaw."""

    mass_kg: float = param("dry mass (kg)", above=0.0)
    inertia_kgm2: tuple[float, float, float] = param(
        "principal moments of inertia about the hull's centre (kg m^2; body)", above=0.0
    )
    cog_z_m: float = param("centre of gravity below the hull's centre (m; body z)", minimum=0.0)
    added_mass: Vec6 = param("added mass (kg) and added inertia (kg m^2), positive", minimum=0.0)
    linear_damping: Vec6 = param("linear damping (N s/m, N m s/rad), positive", minimum=0.0)
    quadratic_damping: Vec6 = param("quadratic damping (N s^2/m^2, N m s^2/rad^2), positive", minimum=0.0)
    weight_n: float = param("weight (N)", above=0.0)
    buoyancy_n: float = param("buoyancy (N)", above=0.0)
    hull_radius_m: float = param("radius of the sphere around the hull (m)", above=0.0)
    max_wrench: Vec6 | None = param(
        "actuator limit per axis (N, N m; body); null: none", default=None, above=0.0
    )
    cog_couples: bool = param(
        "whether z_G couples surge with pitch and sway with roll in M; in g it always counts", default=True
    )

    def __post_init__(self) -> None:
        s = _static_moment_kgm(self)
        for linear, angular, name in ((0, 1, "surge-pitch"), (1, 0, "sway-roll")):
            mass = self.mass_kg + self.added_mass[linear]
            inertia = self.inertia_kgm2[angular] + self.added_mass[3 + angular]
            if mass * inertia <= s * s:
                raise ValueError(
                    f"cog_z_m: {self.cog_z_m!r} is not allowed; allowed: a value for which "
                    f"M is positive definite ({name})"
                )


def _static_moment_kgm(params: Params) -> float:
    """Return m z_G in M and C."""
    return params.mass_kg * params.cog_z_m if params.cog_couples else 0.0


def constants(params: Params) -> Constants:
    """Return the constants of a hull with these parameters."""
    surge_kg, sway_kg, heave_kg = (params.mass_kg + added for added in params.added_mass[:3])
    roll_kgm2, pitch_kgm2, yaw_kgm2 = (
        inertia + added for inertia, added in zip(params.inertia_kgm2, params.added_mass[3:], strict=True)
    )
    return Constants(
        surge_kg, sway_kg, heave_kg, roll_kgm2, pitch_kgm2, yaw_kgm2,
        _static_moment_kgm(params),
        *params.linear_damping,
        *params.quadratic_damping,
        net_weight_n=params.weight_n - params.buoyancy_n,
        righting_nm=params.cog_z_m * params.weight_n,
    )  # fmt: skip


def limits(params: Params) -> Vec6:
    """Return the actuator limit per axis (N, N m; body), infinite if there is none."""
    return (math.inf,) * 6 if params.max_wrench is None else params.max_wrench


@entry("TUPLE6(TUPLE6, TUPLE6)")
@inlined
def limited_wrench(tau: Numbers, most: Vec6) -> Vec6:
    """Return `tau` clipped axis by axis."""
    return (
        clipped(tau[0], most[0]),
        clipped(tau[1], most[1]),
        clipped(tau[2], most[2]),
        clipped(tau[3], most[3]),
        clipped(tau[4], most[4]),
        clipped(tau[5], most[5]),
    )


@inlined
def derivative(state: State, tau: Numbers, current: Vec3, c: Constants) -> State:
    """
    Return the rate of change of the 13 floats of a state.

    Parameters
    ----------
    state : (13,) tuple
        NED position (m), quaternion body to NED (w, x, y, z), nu (m/s, rad/s; body).
    tau : (6,) tuple
        Wrench of the actuators (N, N m; body).
    current : (3,) tuple
        Velocity of the water, uniform and constant (m/s; NED).
    c : Constants
        Of the hull.

    Notes
    -----
    The water is irrotational and steady, so the equations hold for nu_r unchanged (Fossen 2021, property
    10.1); in the body frame the current changes by -omega x nu_c.

    """
    qw, qx, qy, qz = state[3:7]
    u, v, w = state[7:10]
    p, q, r = state[10:13]
    r11, r12, r13 = 1.0 - 2.0 * (qy * qy + qz * qz), 2.0 * (qx * qy - qw * qz), 2.0 * (qx * qz + qw * qy)
    r21, r22, r23 = 2.0 * (qx * qy + qw * qz), 1.0 - 2.0 * (qx * qx + qz * qz), 2.0 * (qy * qz - qw * qx)
    r31, r32, r33 = 2.0 * (qx * qz - qw * qy), 2.0 * (qy * qz + qw * qx), 1.0 - 2.0 * (qx * qx + qy * qy)
    cn, ce, cd = current
    cu = r11 * cn + r21 * ce + r31 * cd
    cv = r12 * cn + r22 * ce + r32 * cd
    cw = r13 * cn + r23 * ce + r33 * cd
    water = (u - cu, v - cv, w - cw)
    rates = (p, q, r)
    (cx, cy, cz), (ck, cm, cr) = coriolis_force(water, rates, c)
    (dx, dy, dz), (dk, dm, dr) = damping_force(water, rates, c)
    heavy, righting = c.net_weight_n, c.righting_nm
    fx = tau[0] - cx - dx + heavy * r31
    fy = tau[1] - cy - dy + heavy * r32
    fz = tau[2] - cz - dz + heavy * r33
    nx = tau[3] - ck - dk - righting * r32
    ny = tau[4] - cm - dm + righting * r31
    nz = tau[5] - cr - dr
    s = c.static_moment_kgm
    surge_pitch = c.surge_kg * c.pitch_kgm2 - s * s
    sway_roll = c.sway_kg * c.roll_kgm2 - s * s
    return (
        r11 * u + r12 * v + r13 * w,
        r21 * u + r22 * v + r23 * w,
        r31 * u + r32 * v + r33 * w,
        -0.5 * (qx * p + qy * q + qz * r),
        0.5 * (qw * p + qy * r - qz * q),
        0.5 * (qw * q + qz * p - qx * r),
        0.5 * (qw * r + qx * q - qy * p),
        (c.pitch_kgm2 * fx - s * ny) / surge_pitch - (q * cw - r * cv),
        (c.roll_kgm2 * fy + s * nx) / sway_roll - (r * cu - p * cw),
        fz / c.heave_kg - (p * cv - q * cu),
        (c.sway_kg * nx + s * fy) / sway_roll,
        (c.surge_kg * ny - s * fx) / surge_pitch,
        nz / c.yaw_kgm2,
    )


@inlined
def _along(x: State, h: float, k: State) -> State:
    """Return x + h k."""
    return (
        x[0] + h * k[0], x[1] + h * k[1], x[2] + h * k[2], x[3] + h * k[3], x[4] + h * k[4],
        x[5] + h * k[5], x[6] + h * k[6], x[7] + h * k[7], x[8] + h * k[8], x[9] + h * k[9],
        x[10] + h * k[10], x[11] + h * k[11], x[12] + h * k[12],
    )  # fmt: skip


@inlined
def normalised(x: State) -> State:
    """Return a state with an attitude quaternion of length 1."""
    norm = math.sqrt(x[3] * x[3] + x[4] * x[4] + x[5] * x[5] + x[6] * x[6])
    return (
        x[0], x[1], x[2], x[3] / norm, x[4] / norm, x[5] / norm, x[6] / norm,
        x[7], x[8], x[9], x[10], x[11], x[12],
    )  # fmt: skip


@inlined
def _rate(t_s: float, x: State, given: tuple[Numbers, Vec3, Constants]) -> State:
    """Return `derivative` for the wrench, current and hull given."""
    tau, current, c = given
    return derivative(x, tau, current, c)


@entry("TUPLE13(TUPLE13, TUPLE6, TUPLE3, TUPLE21, float64, int64)")
def advance(
    x: State, tau: Numbers, current: Vec3, numbers: tuple[float, ...], dt_s: float, steps: int
) -> State:
    """
    Return the state after `steps` steps of `dt_s` with constant tau; `numbers` are the hull's `Constants`.
    """
    c = Constants(*numbers)
    for _ in range(steps):
        x = normalised(rk4(_rate, _along, 0.0, x, dt_s, (tau, current, c)))
    return x


class Model(ContinuousModel):
    """A vehicle that takes a wrench, integrated by RK4."""

    command = "wrench"

    def __init__(self, params: Params) -> None:
        self.params = params
        self._constants = constants(params)
        self._numbers = tuple(self._constants)
        self._limits = limits(params)
        self._advance, self._limited = fastest(advance), fastest(limited_wrench)

    @property
    def handling(self) -> Handling:
        """It hovers."""
        return hovering(self.params.hull_radius_m)

    @property
    def top_speed_mps(self) -> float:
        """Speed that the weakest of the three forces can hold against the drag (m/s); without limits inf."""
        return self.speed_held_mps(math.inf)

    def speed_held_mps(self, max_force_n: float) -> float:
        """Return the same for a controller with this limit along each axis (N)."""
        p = self.params
        return min(
            steady_speed_mps(linear, quadratic, min(force_n, max_force_n))
            for linear, quadratic, force_n in zip(
                p.linear_damping[:3], p.quadratic_damping[:3], self._limits[:3], strict=True
            )
        )

    def kinetic_energy(self, nu: Vec6) -> float:
        """Return nu^T M nu / 2 (J)."""
        (lx, ly, lz), (hx, hy, hz) = momentum((nu[0], nu[1], nu[2]), (nu[3], nu[4], nu[5]), self._constants)
        return 0.5 * (nu[0] * lx + nu[1] * ly + nu[2] * lz + nu[3] * hx + nu[4] * hy + nu[5] * hz)

    def initial_state(self, position: Vec3, heading_rad: float, speed_mps: float = 0.0) -> State:
        """Return the state of a level vehicle that runs ahead at a speed over ground (m/s)."""
        attitude: Quat = quaternion_from_heading(heading_rad)
        return (*position, *attitude, speed_mps, 0.0, 0.0, 0.0, 0.0, 0.0)

    def limited_command(self, tau: Numbers) -> Numbers:
        """Return the wrench of the actuators for a command: clipped per axis, if there are limits."""
        return self._limited(tau, self._limits)

    def step(self, state: State, command: Numbers, current: Vec3, dt_s: float, steps: int = 1) -> State:
        """
        Return the state after `steps` steps of `dt_s`, the wrench `command` held; the quaternion comes back
        with length 1.
        """
        return self._advance(state, command, current, self._numbers, dt_s, steps)

    def derivative(self, state: State, tau: Numbers, current: Vec3) -> State:
        """Return the rate of change of `state`; see the function of the same name."""
        return derivative(state, tau, current, self._constants)

    def normalised(self, state: State) -> State:
        """Return the state with an attitude quaternion of length 1."""
        return normalised(state)
