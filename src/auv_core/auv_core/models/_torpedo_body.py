"""
What all torpedoes share: rigid body and added mass, weight, fin servos and a propeller that follow commands.

    M nu_r_dot + C(nu_r) nu_r + g = force of the water and of the actuators,    nu_r = nu - R^T v_c

(Fossen 2021, Handbook of Marine Craft Hydrodynamics and Motion Control, ch. 6-8). The origin is the centre of
the hull and of buoyancy, at mid length; the centre of gravity lies z_G below it. A state has 16 floats: the
13 of a hull, then rudder and stern plane (rad) and propeller (rpm).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from auv_core.compiled import inlined, record
from auv_core.geometry import Quat, Vec3, added, body_to_ned, clipped, ned_to_body
from auv_core.integrate import State
from auv_core.messages import Numbers, Vec6
from auv_core.models import Actuator
from auv_core.models._hull_forces import turned_momentum
from auv_core.models._rigid_body import acceleration, attitude_rate
from auv_core.params import param

Forces = tuple[Vec3, Vec3]
"""Force (N) and moment (N m) in the body frame."""

ACTUATORS = (Actuator("rudder", "rad"), Actuator("stern_plane", "rad"), Actuator("propeller", "rpm"))


@inlined
def limited(command: Numbers, fin_max_rad: float, propeller_max_rpm: float) -> Numbers:
    """Return rudder, stern plane (rad) and propeller (rpm) within their limits."""
    return (
        clipped(command[0], fin_max_rad),
        clipped(command[1], fin_max_rad),
        clipped(command[2], propeller_max_rpm),
    )


@dataclass(frozen=True, kw_only=True)
class Servos:
    """Limits and delays of fins and propeller."""

    fin_max_rad: float = param("largest angle of rudder and stern plane (rad)", above=0.0, maximum=1.0)
    fin_lag_s: float = param("time constant of the fin servos (s)", above=0.0)
    fin_rate_radps: float | None = param(
        "fastest turning of a fin (rad/s); null: no limit", default=None, above=0.0
    )
    propeller_max_rpm: float = param("highest speed of the propeller, ahead and astern (rpm)", above=0.0)
    propeller_lag_s: float = param("time constant of the propeller (s)", above=0.0)

    def limited(self, command: Numbers) -> Numbers:
        """Return rudder, stern plane (rad) and propeller (rpm) within their limits."""
        return limited(command, self.fin_max_rad, self.propeller_max_rpm)


@record(", ".join(20 * ["float64"]))
class Body(NamedTuple):
    """
    The constants of the body.

    surge_kg, ..., yaw_kgm2: mass and inertia, including added mass.  turning_surge_kg, ...: the mass whose
    momentum turns with the body, which some models keep without added mass.  roll_sway_kg, roll_heave_kg:
    the added mass of heave and sway that then couples with roll only.  static_moment_kgm: m z_G.
    weight_n, buoyancy_n: W, B under water.  diameter_m: of the hull.  righting_nm: z_G W.  The others are
    those of `Servos`.
    """

    surge_kg: float
    sway_kg: float
    heave_kg: float
    roll_kgm2: float
    pitch_kgm2: float
    yaw_kgm2: float
    turning_surge_kg: float
    turning_sway_kg: float
    turning_heave_kg: float
    roll_sway_kg: float
    roll_heave_kg: float
    static_moment_kgm: float
    weight_n: float
    buoyancy_n: float
    diameter_m: float
    righting_nm: float
    fin_max_rad: float
    fin_lag_s: float
    fin_rate_radps: float
    propeller_lag_s: float


class Ballast(NamedTuple):
    """Mass (kg), its centre below the hull's centre (m), weight, weight minus buoyancy (N), diameter (m)."""

    mass_kg: float
    cog_z_m: float
    weight_n: float
    net_weight_n: float
    diameter_m: float


def body(ballast: Ballast, inertia_kgm2: Vec3, added_mass: Vec6, servos: Servos, *, munk: bool) -> Body:
    """
    Return the constants of a body.

    Parameters
    ----------
    ballast : Ballast
        Mass and weight.
    inertia_kgm2 : (3,) tuple
        Principal moments of inertia about the centre of gravity (kg m^2).
    added_mass : (6,) tuple
        Added mass (kg) and added inertia (kg m^2) about the hull's centre, positive.
    servos : Servos
        Limits and delays of the actuators.
    munk : bool
        Whether C has all terms of the added mass (Kirchhoff), or of its linear part only those with roll.

    """
    mass_kg, cog_z_m = ballast.mass_kg, ballast.cog_z_m
    ahead, across, below = added_mass[:3]
    about_x, about_y, about_z = inertia_kgm2
    shift = mass_kg * cog_z_m * cog_z_m
    turning = 1.0 if munk else 0.0
    return Body(
        surge_kg=mass_kg + ahead,
        sway_kg=mass_kg + across,
        heave_kg=mass_kg + below,
        roll_kgm2=about_x + shift + added_mass[3],
        pitch_kgm2=about_y + shift + added_mass[4],
        yaw_kgm2=about_z + added_mass[5],
        turning_surge_kg=mass_kg + turning * ahead,
        turning_sway_kg=mass_kg + turning * across,
        turning_heave_kg=mass_kg + turning * below,
        roll_sway_kg=(1.0 - turning) * below,
        roll_heave_kg=(1.0 - turning) * across,
        static_moment_kgm=mass_kg * cog_z_m,
        weight_n=ballast.weight_n,
        buoyancy_n=ballast.weight_n - ballast.net_weight_n,
        diameter_m=ballast.diameter_m,
        righting_nm=cog_z_m * ballast.weight_n,
        fin_max_rad=servos.fin_max_rad,
        fin_lag_s=servos.fin_lag_s,
        fin_rate_radps=math.inf if servos.fin_rate_radps is None else servos.fin_rate_radps,
        propeller_lag_s=servos.propeller_lag_s,
    )


def kinetic_energy(nu: Vec6, b: Body) -> float:
    """Return nu^T M nu / 2 (J)."""
    u, v, w, p, q, r = nu
    inertial = b.surge_kg * u * u + b.sway_kg * v * v + b.heave_kg * w * w
    rotating = b.roll_kgm2 * p * p + b.pitch_kgm2 * q * q + b.yaw_kgm2 * r * r
    return 0.5 * (inertial + rotating) + b.static_moment_kgm * (u * q - v * p)


@inlined
def through_water(state: State, current: Vec3) -> Vec3:
    """Return the velocity relative to the water (m/s; body)."""
    cu, cv, cw = ned_to_body((state[3], state[4], state[5], state[6]), current)
    return (state[7] - cu, state[8] - cv, state[9] - cw)


@inlined
def summed(a: Forces, b: Forces) -> Forces:
    """Return a + b."""
    return added(a[0], b[0]), added(a[1], b[1])


@inlined
def _turning_force(water: Vec3, rates: Vec3, b: Body) -> Forces:
    """Return C(nu_r) nu_r (N, N m; body)."""
    u, v, w = water
    p, q, r = rates
    s = b.static_moment_kgm
    (x, y, z), moment = turned_momentum(
        water,
        rates,
        (b.turning_surge_kg * u + s * q, b.turning_sway_kg * v - s * p, b.turning_heave_kg * w),
        (b.roll_kgm2 * p - s * v, b.pitch_kgm2 * q + s * u, b.yaw_kgm2 * r),
    )
    return (x, y - b.roll_sway_kg * w * p, z + b.roll_heave_kg * v * p), moment


@inlined
def _gravity_force(attitude: Quat, depth_m: float, b: Body) -> Forces:
    """
    Return the force and moment of weight and buoyancy (N, N m; body).

    The buoyancy falls while the hull comes out of the water, so that a light one floats at the surface.
    """
    qw, qx, qy, qz = attitude
    x = 2.0 * (qx * qz - qw * qy)
    y = 2.0 * (qy * qz + qw * qx)
    z = 1.0 - 2.0 * (qx * qx + qy * qy)
    under = min(max(0.5 + depth_m / b.diameter_m, 0.0), 1.0)
    heavy, righting = b.weight_n - under * b.buoyancy_n, b.righting_nm
    return (heavy * x, heavy * y, heavy * z), (-righting * y, righting * x, 0.0)


@inlined
def motion(state: State, command: Numbers, current: Vec3, forces: Forces, b: Body) -> State:
    """
    Return the rate of change of the 16 floats of a state.

    Parameters
    ----------
    state : (16,) tuple
        NED position (m), quaternion body to NED (w, x, y, z), nu (m/s, rad/s; body), rudder and stern plane
        (rad), propeller (rpm).
    command : (3,) tuple
        Commanded rudder and stern plane (rad) and propeller (rpm).
    current : (3,) tuple
        Velocity of the water, uniform and constant (m/s; NED).
    forces : pair of (3,) tuples
        Force and moment of the water and of the actuators on the hull (N, N m; body).
    b : Body
        Its constants.

    Notes
    -----
    The water is irrotational and steady, so the equations hold for nu_r unchanged (Fossen 2021, property
    10.1); in the body frame the current changes by -omega x R^T v_c.

    """
    attitude = (state[3], state[4], state[5], state[6])
    velocity, rates = (state[7], state[8], state[9]), (state[10], state[11], state[12])
    x, y, z = body_to_ned(attitude, velocity)
    cu, cv, cw = ned_to_body(attitude, current)
    water = (velocity[0] - cu, velocity[1] - cv, velocity[2] - cw)
    (tx, ty, tz), (tk, tm, tn) = _turning_force(water, rates, b)
    (gx, gy, gz), (gk, gm, _) = _gravity_force(attitude, state[2], b)
    (fx, fy, fz), (fk, fm, fn) = forces
    fx, fy, fz = fx - tx + gx, fy - ty + gy, fz - tz + gz
    fk, fm, fn = fk - tk + gk, fm - tm + gm, fn - tn
    aw, ax, ay, az = attitude_rate(attitude, rates)
    (du, dv, dw), (dp, dq, dr) = acceleration((fx, fy, fz), (fk, fm, fn), rates, (cu, cv, cw), b)
    fin, most = b.fin_lag_s, b.fin_rate_radps
    return (
        x, y, z,
        aw, ax, ay, az,
        du, dv, dw,
        dp, dq, dr,
        clipped((command[0] - state[13]) / fin, most),
        clipped((command[1] - state[14]) / fin, most),
        (command[2] - state[15]) / b.propeller_lag_s,
    )  # fmt: skip


@inlined
def along(x: State, h: float, k: State) -> State:
    """Return x + h k."""
    return (
        x[0] + h * k[0], x[1] + h * k[1], x[2] + h * k[2], x[3] + h * k[3], x[4] + h * k[4],
        x[5] + h * k[5], x[6] + h * k[6], x[7] + h * k[7], x[8] + h * k[8], x[9] + h * k[9],
        x[10] + h * k[10], x[11] + h * k[11], x[12] + h * k[12], x[13] + h * k[13],
        x[14] + h * k[14], x[15] + h * k[15],
    )  # fmt: skip


@inlined
def normalised(x: State) -> State:
    """Return a state with an attitude quaternion of length 1."""
    norm = math.sqrt(x[3] * x[3] + x[4] * x[4] + x[5] * x[5] + x[6] * x[6])
    return (
        x[0], x[1], x[2], x[3] / norm, x[4] / norm, x[5] / norm, x[6] / norm,
        x[7], x[8], x[9], x[10], x[11], x[12], x[13], x[14], x[15],
    )  # fmt: skip
