"""
Torpedo whose hydrodynamics are published as coefficients: linear and quadratic damping, lift, fins, thrust.

    force = -(D + D_n(|nu_r|) + L u) nu_r + fins u^2 + thrust

with the derivatives of SNAME (1950), such as Y_v, for a hull that is symmetric about its axis (Prestero 2001;
da Silva et al. 2007, Modeling and simulation of the LAUV autonomous underwater vehicle). They hold for a hull
that runs ahead. Rigid body, added mass, servos and the lag of the propeller are those of `torpedo`.

Deviation: the sources command a thrust; here the speed of the propeller is commanded, as for all torpedoes,
and gives the thrust thrust_max (n / n_max) |n / n_max|.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass, replace
from typing import Any, NamedTuple

from auv_core.compiled import entry, inlined
from auv_core.geometry import Vec3, clipped
from auv_core.integrate import State, rk4
from auv_core.messages import Numbers
from auv_core.models._spheroid import Spheroid
from auv_core.models._torpedo_body import (
    Ballast,
    Body,
    Forces,
    Servos,
    along,
    body,
    motion,
    normalised,
    through_water,
)
from auv_core.models._torpedo_model import Equations, TorpedoModel
from auv_core.params import param

_BODY_NUMBERS = len(Body._fields)


@dataclass(frozen=True, kw_only=True)
class Derivatives:
    """Derivatives of force and moment by one velocity each; a brake is negative."""

    x_u: float = param("X by u", default=0.0)
    y_v: float = param("Y by v", default=0.0)
    y_r: float = param("Y by r", default=0.0)
    z_w: float = param("Z by w", default=0.0)
    z_q: float = param("Z by q", default=0.0)
    k_p: float = param("K by p", default=0.0)
    m_w: float = param("M by w", default=0.0)
    m_q: float = param("M by q", default=0.0)
    n_v: float = param("N by v", default=0.0)
    n_r: float = param("N by r", default=0.0)


@dataclass(frozen=True, kw_only=True)
class Fins:
    """Force and moment of the fins per u^2 and angle; with these signs r > 0 for a rudder > 0."""

    y_rudder: float = param("Y by the rudder (N s^2/m^2 per rad)")
    n_rudder: float = param("N by the rudder (N s^2/m per rad)", above=0.0)
    z_stern_plane: float = param("Z by the stern planes (N s^2/m^2 per rad)")
    m_stern_plane: float = param("M by the stern planes (N s^2/m per rad); negative: the nose falls")


@dataclass(frozen=True, kw_only=True)
class Params:
    """Numbers of a torpedo; moments of derivatives are about the hull's centre."""

    mass_kg: float = param("dry mass (kg)", above=0.0)
    length_m: float = param("length (m)", above=0.0)
    diameter_m: float = param("diameter (m)", above=0.0)
    cog_z_m: float = param("centre of gravity below the hull's centre (m; body z)", above=0.0)
    gravity_mps2: float = param("gravity (m/s^2)", above=0.0)
    net_weight_n: float = param("weight minus buoyancy (N)", default=0.0)
    lost_buoyancy_n: float = param(
        "buoyancy minus weight after the loss of the vehicle's computer, which drops a weight (N)",
        default=0.0,
    )
    linear: Derivatives = param("linear damping (N s/m, N s/rad, N m s/rad)")
    quadratic: Derivatives = param("quadratic damping, times |v| v and so on (N s^2/m^2, N m s^2/rad^2)")
    lift: Derivatives = param("lift of hull and fins, times u v and so on (N s^2/m^2, N s^2/m, N s^2)")
    fins: Fins = param("rudder and stern planes")
    thrust_max_n: float = param("thrust at the highest speed of the propeller (N)", above=0.0)
    servos: Servos = param("limits and delays of fins and propeller")
    least_speed_mps: float = param(
        "least speed through the water at which the stern planes hold the pitch (m/s)", above=0.0
    )
    near_m: float = param(
        "distance from another hull's centre below which a report warns (m)", default=5.0, minimum=0.0
    )

    def __post_init__(self) -> None:
        if self.diameter_m >= self.length_m:
            raise ValueError(
                f"diameter_m: {self.diameter_m!r} is not allowed; allowed: less than the length, "
                f"{self.length_m!r} m"
            )


class Slopes(NamedTuple):
    """The numbers of `Derivatives`, in their order."""

    x_u: float
    y_v: float
    y_r: float
    z_w: float
    z_q: float
    k_p: float
    m_w: float
    m_q: float
    n_v: float
    n_r: float


class FinSlopes(NamedTuple):
    """The numbers of `Fins`, in their order."""

    y_rudder: float
    n_rudder: float
    z_stern_plane: float
    m_stern_plane: float


class Coefficients(NamedTuple):
    """The constants of the forces: damping, lift, fins, and thrust per square of the speed (N/rpm^2)."""

    linear: Slopes
    quadratic: Slopes
    lift: Slopes
    fins: FinSlopes
    thrust_nprpm2: float


_QUADRATIC = len(Slopes._fields)
_LIFT = 2 * _QUADRATIC
_FINS = 3 * _QUADRATIC
_THRUST = _FINS + len(FinSlopes._fields)


@inlined
def _coefficients(numbers: Numbers) -> Coefficients:
    """Return the coefficients from their numbers, one after the other."""
    return Coefficients(
        Slopes(*numbers[:_QUADRATIC]),
        Slopes(*numbers[_QUADRATIC:_LIFT]),
        Slopes(*numbers[_LIFT:_FINS]),
        FinSlopes(*numbers[_FINS:_THRUST]),
        numbers[_THRUST],
    )


def body_of(params: Params) -> Body:
    """Return the constants of the body: C has all terms of the added mass."""
    shape = Spheroid(0.5 * params.length_m, 0.5 * params.diameter_m)
    mass = params.mass_kg
    return body(
        Ballast(mass, params.cog_z_m, mass * params.gravity_mps2, params.net_weight_n, params.diameter_m),
        shape.inertia_kgm2(mass),
        shape.added_mass(mass, 0.0),
        params.servos,
        munk=True,
    )


def numbers_of(params: Params) -> Numbers:
    """Return the numbers of the coefficients."""
    thrust_nprpm2 = params.thrust_max_n / params.servos.propeller_max_rpm**2
    slopes = (*astuple(params.linear), *astuple(params.quadratic), *astuple(params.lift))
    return (*slopes, *astuple(params.fins), thrust_nprpm2)


@inlined
def _product(s: Slopes, velocity: Vec3, rates: Vec3) -> Forces:
    """Return derivatives times velocities."""
    u, v, w = velocity
    p, q, r = rates
    return (
        (s.x_u * u, s.y_v * v + s.y_r * r, s.z_w * w + s.z_q * q),
        (s.k_p * p, s.m_w * w + s.m_q * q, s.n_v * v + s.n_r * r),
    )


@inlined
def _signed_squares(v: Vec3) -> Vec3:
    return (abs(v[0]) * v[0], abs(v[1]) * v[1], abs(v[2]) * v[2])


@inlined
def water_force(water: Vec3, rates: Vec3, c: Coefficients) -> Forces:
    """Return the force of damping and lift (N, N m; body) for a velocity relative to the water."""
    (ax, ay, az), (ak, am, an) = _product(c.linear, water, rates)
    (bx, by, bz), (bk, bm, bn) = _product(c.quadratic, _signed_squares(water), _signed_squares(rates))
    (cx, cy, cz), (ck, cm, cn) = _product(c.lift, water, rates)
    u = water[0]
    return (
        (ax + bx + u * cx, ay + by + u * cy, az + bz + u * cz),
        (ak + bk + u * ck, am + bm + u * cm, an + bn + u * cn),
    )


@inlined
def rate(_t_s: float, state: State, given: tuple[Numbers, Vec3, Body, Coefficients]) -> State:
    """Return the rate of change of a state for the command, the current and the hull given."""
    command, current, b, c = given
    water, rates = through_water(state, current), (state[10], state[11], state[12])
    (x, y, z), (k, m, n) = water_force(water, rates, c)
    fins, square = c.fins, water[0] * water[0]
    rudder, stern_plane = (
        square * clipped(state[13], b.fin_max_rad),
        square * clipped(state[14], b.fin_max_rad),
    )
    thrust_n = c.thrust_nprpm2 * abs(state[15]) * state[15]
    forces = (
        (x + thrust_n, y + fins.y_rudder * rudder, z + fins.z_stern_plane * stern_plane),
        (k, m + fins.m_stern_plane * stern_plane, n + fins.n_rudder * rudder),
    )
    return motion(state, command, current, forces, b)


@entry("TUPLE16(TUPLE16, TUPLE3, TUPLE3, TUPLE55, float64, int64)")
def advance(x: State, command: Numbers, current: Vec3, numbers: Numbers, dt_s: float, steps: int) -> State:
    """
    Return the state after `steps` steps of `dt_s` with a constant command; `numbers` are those of the body
    and of the coefficients.
    """
    b, c = Body(*numbers[:_BODY_NUMBERS]), _coefficients(numbers[_BODY_NUMBERS:])
    for _ in range(steps):
        x = normalised(rk4(rate, along, 0.0, x, dt_s, (command, current, b, c)))
    return x


class Model(TorpedoModel):
    """A torpedo with the forces of published coefficients."""

    def __init__(self, params: Params) -> None:
        numbers = numbers_of(params)
        equations = Equations(rate, advance)
        super().__init__(params, body_of(params), _coefficients(numbers), numbers, equations)

    def adrift(self) -> Model:
        """Return the hull without its drop weight."""
        params: Any = self.params
        return Model(replace(params, net_weight_n=-params.lost_buoyancy_n))
