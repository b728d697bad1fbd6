"""
Torpedo: a slender hull with rudder, stern planes and one propeller, its forces from lift and strip theory.

The hull is a spheroid with the added mass of potential theory (`_spheroid`). Its forces are linear
damping, the lift and drag of a wing of low aspect ratio in the vertical plane (Beard and McLain 2012), and
cross-flow drag on strips along the hull (Hoerner 1965); its propeller has the open-water lines of Allen,
Vorus and Prestero (2000). The equations are those of Fossen's REMUS 100 (Fossen 2021, Handbook of Marine
Craft Hydrodynamics and Motion Control, ch. 6-9, and its published programs).

Deviation: beyond the stall angle the lift and the induced drag fade; in the published programs a hull that
rises level glides ahead without end. Below 10 degrees this changes nothing.

Deviation: the propeller's speed of advance is through the water; the published programs take the speed over
ground (``advance_by: ground``), which differs in a current only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from auv_core.compiled import entry, inlined
from auv_core.geometry import Vec3, clipped
from auv_core.integrate import State, rk4
from auv_core.messages import Numbers
from auv_core.models._slender_hull import STRIPS, Water, fin_force, hull_force, propeller_force
from auv_core.models._spheroid import Spheroid
from auv_core.models._torpedo_body import (
    Ballast,
    Body,
    Servos,
    along,
    body,
    motion,
    normalised,
    summed,
    through_water,
)
from auv_core.models._torpedo_model import Equations, TorpedoModel
from auv_core.params import param

_OSWALD = 0.7
_BODY_NUMBERS = len(Body._fields)


@dataclass(frozen=True, kw_only=True)
class Hull:
    """Size, ballast and hydrodynamics of the hull."""

    length_m: float = param("length (m)", above=0.0)
    diameter_m: float = param("diameter (m)", above=0.0)
    spheroid_ratio: float = param(
        "axes of the spheroid that has the mass of the hull, over those of the hull", default=1.0, above=0.0
    )
    cog_z_m: float = param("centre of gravity below the hull's centre (m; body z)", above=0.0)
    net_weight_n: float = param("weight minus buoyancy (N)", default=0.0)
    lost_buoyancy_n: float = param(
        "buoyancy minus weight after the loss of the vehicle's computer, which drops a weight (N)",
        default=0.0,
    )
    roll_added_ratio: float = param("added inertia in roll over the inertia", minimum=0.0)
    surge_time_s: float = param("time constant of surge at rest (s)", above=0.0)
    sway_time_s: float = param("time constant of heave, and of sway at rest (s)", above=0.0)
    yaw_time_s: float = param("time constant of yaw (s)", above=0.0)
    roll_damping_ratio: float = param("damping ratio of roll", above=0.0)
    pitch_damping_ratio: float = param("damping ratio of pitch", above=0.0)
    lift_area_ratio: float = param("area of lift and drag over length times diameter", above=0.0)
    frontal_drag: float = param("drag coefficient at zero angle of attack, on the frontal area", above=0.0)
    cross_flow_drag: float = param("drag coefficient of a strip across the flow", minimum=0.0)
    cross_flow: str = param("planes with cross-flow drag", default="both", choices=("both", "horizontal"))
    lift_in_both_planes: bool = param(
        "whether the hull lifts in sway, too; the published model does not", default=False
    )
    munk: bool = param(
        "whether the added mass has all its Coriolis terms; the published model has those with roll only",
        default=False,
    )

    def __post_init__(self) -> None:
        if self.diameter_m >= self.length_m:
            raise ValueError(
                f"diameter_m: {self.diameter_m!r} is not allowed; allowed: less than the length, "
                f"{self.length_m!r} m"
            )

    @property
    def lift_area_m2(self) -> float:
        """Area of lift and drag (m^2)."""
        return self.lift_area_ratio * self.length_m * self.diameter_m


@dataclass(frozen=True, kw_only=True)
class Fins:
    """Rudder and stern planes."""

    area_m2: float = param("area of the two fins of a pair (m^2)", above=0.0)
    x_m: float = param("place ahead of the hull's centre; negative: astern (m; body x)")
    rudder_lift: float = param("lift coefficient of the rudder per angle (1/rad)", above=0.0)
    stern_plane_lift: float = param("lift coefficient of the stern planes per angle (1/rad)", above=0.0)


@dataclass(frozen=True, kw_only=True)
class Propeller:
    """Open-water lines of the propeller, straight between rest and the largest advance ratio."""

    diameter_m: float = param("diameter (m)", above=0.0)
    thrust_deduction: float = param("part of the thrust that the hull takes (-)", minimum=0.0, maximum=0.9)
    wake_ratio: float = param("speed of advance over the speed of the hull", above=0.0)
    thrust_at_rest: float = param("thrust coefficient K_T at rest", above=0.0)
    thrust_in_advance: float = param("thrust coefficient K_T at the largest advance ratio")
    torque_at_rest: float = param("torque coefficient K_Q at rest", above=0.0)
    torque_in_advance: float = param("torque coefficient K_Q at the largest advance ratio")
    largest_advance: float = param("largest advance ratio", above=0.0)
    roll_ratio: float = param("roll moment on the hull over the torque of the propeller", minimum=0.0)
    advance_by: str = param(
        "speed of the hull that the propeller meets", default="water", choices=("water", "ground")
    )


@dataclass(frozen=True, kw_only=True)
class Params:
    """Numbers of a torpedo."""

    water_density_kgpm3: float = param("density of the water (kg/m^3)", above=0.0)
    gravity_mps2: float = param("gravity (m/s^2)", above=0.0)
    hull: Hull = param("the hull")
    fins: Fins = param("the fins")
    propeller: Propeller = param("the propeller")
    servos: Servos = param("limits and delays of fins and propeller")
    least_speed_mps: float = param(
        "least speed through the water at which the stern planes hold the pitch (m/s)", above=0.0
    )
    near_m: float = param(
        "distance from another hull's centre below which a report warns (m)", default=5.0, minimum=0.0
    )

    @property
    def length_m(self) -> float:
        """Length of the hull (m)."""
        return self.hull.length_m

    @property
    def diameter_m(self) -> float:
        """Diameter of the hull (m)."""
        return self.hull.diameter_m


def spheroid(hull: Hull) -> Spheroid:
    """Return the spheroid that has the mass and the added mass of a hull."""
    half = 0.5 * hull.spheroid_ratio
    return Spheroid(half * hull.length_m, half * hull.diameter_m)


def mass_kg(params: Params) -> float:
    """Return the mass of the water that the spheroid displaces, which the hull has too (kg)."""
    return params.water_density_kgpm3 * spheroid(params.hull).volume_m3


def body_of(params: Params) -> Body:
    """Return the constants of the body."""
    hull, mass = params.hull, mass_kg(params)
    shape = spheroid(hull)
    return body(
        Ballast(mass, hull.cog_z_m, mass * params.gravity_mps2, hull.net_weight_n, hull.diameter_m),
        shape.inertia_kgm2(mass),
        shape.added_mass(mass, hull.roll_added_ratio),
        params.servos,
        munk=hull.munk,
    )


def natural_frequencies_radps(params: Params) -> tuple[float, float]:
    """Return the natural frequencies of roll and pitch, sqrt(z_G W / M) (rad/s)."""
    b = body_of(params)
    return math.sqrt(b.righting_nm / b.roll_kgm2), math.sqrt(b.righting_nm / b.pitch_kgm2)


def lift_per_rad(hull: Hull) -> float:
    """Return the lift coefficient per angle of attack, that of a wing of this aspect ratio (1/rad)."""
    aspect = hull.diameter_m * hull.diameter_m / hull.lift_area_m2
    return math.pi * aspect / (1.0 + math.sqrt(1.0 + 0.25 * aspect * aspect))


def drag_at_zero(hull: Hull) -> float:
    """Return the drag coefficient at zero angle of attack on the area of lift and drag."""
    return hull.frontal_drag * math.pi * 0.25 * hull.diameter_m * hull.diameter_m / hull.lift_area_m2


def water_of(params: Params) -> Water:
    """Return the constants of the forces of the water and of the actuators."""
    hull, fins, propeller = params.hull, params.fins, params.propeller
    density, b = params.water_density_kgpm3, body_of(params)
    roll_radps, pitch_radps = natural_frequencies_radps(params)
    aspect = hull.diameter_m * hull.diameter_m / hull.lift_area_m2
    thrust = (1.0 - propeller.thrust_deduction) * density * propeller.diameter_m**3
    roll = propeller.roll_ratio * density * propeller.diameter_m**4
    advance = propeller.wake_ratio / propeller.largest_advance
    return Water(
        damping_surge_kgps=b.surge_kg / hull.surge_time_s,
        damping_sway_kgps=b.sway_kg / hull.sway_time_s,
        damping_heave_kgps=b.heave_kg / hull.sway_time_s,
        damping_roll_nms=2.0 * hull.roll_damping_ratio * roll_radps * b.roll_kgm2,
        damping_pitch_nms=2.0 * hull.pitch_damping_ratio * pitch_radps * b.pitch_kgm2,
        damping_yaw_nms=b.yaw_kgm2 / hull.yaw_time_s,
        pressure_kgpm=0.5 * density * hull.lift_area_m2,
        lift=lift_per_rad(hull),
        drag=drag_at_zero(hull),
        induced_drag=1.0 / (_OSWALD * math.pi * aspect),
        strip_kgpm=0.5 * density * hull.diameter_m * hull.cross_flow_drag * hull.length_m / STRIPS,
        is_vertical=1.0 if hull.cross_flow == "both" else 0.0,
        lifts_sideways=1.0 if hull.lift_in_both_planes else 0.0,
        length_m=hull.length_m,
        rudder_kgpm=0.5 * density * fins.area_m2 * fins.rudder_lift,
        stern_plane_kgpm=0.5 * density * fins.area_m2 * fins.stern_plane_lift,
        fin_x_m=fins.x_m,
        thrust_kgm=thrust * propeller.diameter_m * propeller.thrust_at_rest,
        advance_thrust_kg=thrust * advance * (propeller.thrust_in_advance - propeller.thrust_at_rest),
        roll_kgm2=roll * propeller.diameter_m * propeller.torque_at_rest,
        advance_roll_kgm=roll * advance * (propeller.torque_in_advance - propeller.torque_at_rest),
        is_by_ground=1.0 if propeller.advance_by == "ground" else 0.0,
    )


@inlined
def rate(_t_s: float, state: State, given: tuple[Numbers, Vec3, Body, Water]) -> State:
    """Return the rate of change of a state for the command, the current and the hull given."""
    command, current, b, c = given
    water, rates = through_water(state, current), (state[10], state[11], state[12])
    advancing = (state[7], state[8], state[9]) if c.is_by_ground > 0.0 else water
    u, v, w = advancing
    thrust_n, roll_nm = propeller_force(math.sqrt(u * u + v * v + w * w), state[15], c)
    rudder_rad, stern_plane_rad = clipped(state[13], b.fin_max_rad), clipped(state[14], b.fin_max_rad)
    forces = summed(hull_force(water, rates, c), fin_force(water, rudder_rad, stern_plane_rad, c))
    return motion(state, command, current, summed(forces, ((thrust_n, 0.0, 0.0), (roll_nm, 0.0, 0.0))), b)


@entry("TUPLE16(TUPLE16, TUPLE3, TUPLE3, TUPLE42, float64, int64)")
def advance(x: State, command: Numbers, current: Vec3, numbers: Numbers, dt_s: float, steps: int) -> State:
    """
    Return the state after `steps` steps of `dt_s` with a constant command; `numbers` are `Body` and `Water`.
    """
    b, c = Body(*numbers[:_BODY_NUMBERS]), Water(*numbers[_BODY_NUMBERS:])
    for _ in range(steps):
        x = normalised(rk4(rate, along, 0.0, x, dt_s, (command, current, b, c)))
    return x


class Model(TorpedoModel):
    """A torpedo with the forces of lift and strip theory."""

    def __init__(self, params: Params) -> None:
        water = water_of(params)
        super().__init__(params, body_of(params), water, tuple(water), Equations(rate, advance))

    def adrift(self) -> Model:
        """Return the hull without its drop weight."""
        params: Any = self.params
        return Model(replace(params, hull=replace(params.hull, net_weight_n=-params.hull.lost_buoyancy_n)))
