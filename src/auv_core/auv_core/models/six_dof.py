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

With ``actuators: wrench`` the hull takes a wrench, which acts at once within ``max_wrench``. With
``actuators: thrusters`` it takes one force for each of its ``thrusters``, whose forces are part of the state.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.compiled import entry, fastest, inlined
from auv_core.drag import steady_speed_mps
from auv_core.geometry import Quat, Vec3, clipped, quaternion_from_heading
from auv_core.integrate import State
from auv_core.messages import Numbers, Vec6
from auv_core.models import HULL, Actuator, ContinuousModel, Handling, hovering
from auv_core.models._hull_forces import Constants as Constants
from auv_core.models._hull_forces import momentum
from auv_core.models._rigid_body import advance as advance
from auv_core.models._rigid_body import derivative as derivative
from auv_core.models._rigid_body import normalised as normalised
from auv_core.models._thruster_drive import ThrusterDrive
from auv_core.params import param
from auv_core.thrusters import Thrusters


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
        "actuator limit per axis (N, N m; body) of a hull that takes a wrench; null: none",
        default=None,
        above=0.0,
    )
    actuators: str = param(
        "what the hull takes: a wrench, or one force for each thruster",
        default="wrench",
        choices=("wrench", "thrusters"),
    )
    thrusters: Thrusters = param("the thrusters, for `actuators: thrusters`", default=Thrusters())
    cog_couples: bool = param(
        "whether z_G couples surge with pitch and sway with roll in M; in g it always counts", default=True
    )

    def __post_init__(self) -> None:
        if self.actuators == "thrusters" and self.thrusters.count == 0:
            raise ValueError(
                "actuators: 'thrusters' is not allowed; allowed: wrench, unless the vehicle has thrusters"
            )
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


class Model(ContinuousModel):
    """A vehicle that takes a wrench or the forces of its thrusters, integrated by RK4."""

    def __init__(self, params: Params) -> None:
        self.params = params
        self._constants = constants(params)
        self._numbers = tuple(self._constants)
        self._drive = ThrusterDrive(params.thrusters) if params.actuators == "thrusters" else None
        self._limits = limits(params) if self._drive is None else self._drive.axis_limits
        self._advance, self._limited = fastest(advance), fastest(limited_wrench)

    @property
    def command(self) -> str:
        """What it takes, `wrench` or `thrusters`."""
        return self.params.actuators

    @property
    def actuators(self) -> tuple[Actuator, ...]:  # type: ignore[override]
        """Its thrusters; none if it takes a wrench."""
        return () if self._drive is None else self._drive.actuators

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
        """Return the state of a level vehicle that runs ahead at a speed over ground (m/s), without force."""
        attitude: Quat = quaternion_from_heading(heading_rad)
        return (*position, *attitude, speed_mps, 0.0, 0.0, 0.0, 0.0, 0.0, *(0.0 for _ in self.actuators))

    def resting_command(self) -> Numbers:
        """Return no wrench, or no force of any thruster."""
        return (0.0,) * (6 if self._drive is None else len(self.actuators))

    def limited_command(self, command: Numbers) -> Numbers:
        """
        Return the wrench of the actuators for a command, clipped per axis, or the forces of the thrusters to
        which they tend (N).
        """
        return self._limited(command, self._limits) if self._drive is None else self._drive.delivered(command)

    def step(self, state: State, command: Numbers, current: Vec3, dt_s: float, steps: int = 1) -> State:
        """
        Return the state after `steps` steps of `dt_s`, the output of `limited_command` held; the quaternion
        comes back with length 1.
        """
        if self._drive is None:
            return self._advance(state, command, current, self._numbers, dt_s, steps)
        return self._drive.advance(state, command, current, self._numbers, dt_s, steps)

    def derivative(self, state: State, command: Numbers, current: Vec3) -> State:
        """Return the rate of change of `state` for the output of `limited_command`."""
        if self._drive is None:
            return derivative(state, command, current, self._constants)
        hull = derivative(state[:HULL], self._drive.wrench(state), current, self._constants)
        return (*hull, *self._drive.rates(state, command))

    def normalised(self, state: State) -> State:
        """Return the state with an attitude quaternion of length 1."""
        return (*normalised(state[:HULL]), *state[HULL:])
