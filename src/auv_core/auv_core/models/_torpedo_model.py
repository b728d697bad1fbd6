"""The part of a torpedo's model that does not depend on how its hydrodynamics are given."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from functools import cache
from typing import Any, NamedTuple, Protocol

import numpy as np

from auv_core.compiled import fastest
from auv_core.geometry import Vec3, quaternion_from_heading
from auv_core.integrate import State
from auv_core.messages import Numbers, Vec6
from auv_core.models import ContinuousModel, Handling
from auv_core.models._torpedo_body import ACTUATORS, Body, Servos, kinetic_energy, normalised

_STILL: Vec3 = (0.0, 0.0, 0.0)
_ORIGIN: Vec3 = (0.0, 0.0, 0.0)
_FASTEST_MPS = 50.0
_HALVINGS = 60
_TURNS = 4
_TURN_S = 25.0
_STEP_S = 0.1
_STEPS_PER_LAG = 2.0


class TorpedoParams(Hashable, Protocol):
    """What this part reads of a torpedo's parameters."""

    @property
    def servos(self) -> Servos:
        """Limits and delays of fins and propeller."""

    @property
    def least_speed_mps(self) -> float:
        """Least speed through the water at which the stern planes hold the pitch (m/s)."""

    @property
    def length_m(self) -> float:
        """Length of the hull (m)."""

    @property
    def diameter_m(self) -> float:
        """Diameter of the hull (m)."""

    @property
    def near_m(self) -> float:
        """Distance from another hull's centre below which a report warns (m)."""


class Turn(NamedTuple):
    """A steady turn with full rudder: speed through the water (m/s) and radius (m)."""

    speed_mps: float
    radius_m: float


class Equations(NamedTuple):
    """
    The functions of a kind of torpedo.

    rate : callable
        ``rate(t_s, state, (command, current, body, water))``, the rate of change of a state.
    advance : callable
        An entry: ``advance(state, command, current, numbers, dt_s, steps)`` is the state after some steps.

    """

    rate: Callable[[float, State, Any], State]
    advance: Callable[..., State]


class TorpedoModel(ContinuousModel):
    """
    A vehicle that takes angles of rudder and stern plane and a speed of its propeller, integrated by RK4.

    Parameters
    ----------
    params : TorpedoParams
        Parameters of the kind.
    body, water : Body, NamedTuple
        Constants of the body, and of the forces on it.
    water_numbers : tuple of float
        The latter, number after number.
    equations : Equations
        The functions of the kind; `advance` takes the numbers of body and water as one tuple.

    """

    command = "fins"
    actuators = ACTUATORS
    numbers: Numbers
    """Constants of the body, then of the water, as `Equations.advance` takes them."""

    def __init__(
        self, params: Any, body: Body, water: Any, water_numbers: Numbers, equations: Equations
    ) -> None:
        self.params: TorpedoParams = params
        self._body, self._water = body, water
        self.numbers = (*body, *water_numbers)
        self._rate, self._advance = equations.rate, fastest(equations.advance)

    @property
    def handling(self) -> Handling:
        """It cannot stop."""
        p = self.params
        return Handling(False, p.least_speed_mps, p.length_m, p.diameter_m, p.near_m)

    @property
    def top_speed_mps(self) -> float:
        """Speed ahead through the water at the highest speed of the propeller (m/s)."""
        return self.steady_speed_mps(self.params.servos.propeller_max_rpm)

    @property
    def longest_step_s(self) -> float:
        """Twice the shorter lag of the actuators (s): RK4 is stable up to 2.8 times."""
        servos = self.params.servos
        return _STEPS_PER_LAG * min(servos.fin_lag_s, servos.propeller_lag_s)

    def speed_held_mps(self, max_force_n: float) -> float:
        """Return the top speed: a controller of a torpedo limits no force."""
        return self.top_speed_mps

    def steady_speed_mps(self, propeller_rpm: float) -> float:
        """Return the speed ahead, level and through the water, at a speed of the propeller (m/s)."""
        return _steady_speed_mps(type(self), self.params, propeller_rpm)

    def steady_rpm(self, speed_mps: float) -> float:
        """Return the speed of the propeller that holds a speed through the water, or its limit (rpm)."""
        return _steady_rpm(type(self), self.params, speed_mps) if speed_mps > 0.0 else 0.0

    def ahead_mps2(self, speed_mps: float, propeller_rpm: float) -> float:
        """Return the acceleration ahead of the level hull (m/s^2)."""
        state = self._running(_ORIGIN, 0.0, speed_mps, propeller_rpm)
        return self.derivative(state, (0.0, 0.0, propeller_rpm), _STILL)[7]

    def turn_radius_m(self, speed_mps: float) -> float:
        """
        Return the radius of the turn with full rudder at a speed through the water (m): between the turns
        that were flown it is almost linear in the inverse of the speed.
        """
        turns = self.turns()
        inverse_spm = [1.0 / turn.speed_mps for turn in reversed(turns)]
        radii_m = [turn.radius_m for turn in reversed(turns)]
        return float(np.interp(1.0 / max(speed_mps, turns[0].speed_mps), inverse_spm, radii_m))

    def turns(self) -> tuple[Turn, ...]:
        """Return steady turns with full rudder from the least to the top speed, flown by this model."""
        return _turns(type(self), self.params)

    def flown_turn(self, propeller_rpm: float) -> Turn:
        """Return the turn that full rudder gives at a speed of the propeller."""
        command = (self.params.servos.fin_max_rad, 0.0, propeller_rpm)
        state = self._running(_ORIGIN, 0.0, self.steady_speed_mps(propeller_rpm), propeller_rpm)
        u, v, *_, r = self.step(state, command, _STILL, _STEP_S, round(_TURN_S / _STEP_S))[7:13]
        speed_mps = math.hypot(u, v)
        return Turn(speed_mps, speed_mps / abs(r))

    def kinetic_energy(self, nu: Vec6) -> float:
        """Return nu^T M nu / 2 (J)."""
        return kinetic_energy(nu, self._body)

    def initial_state(self, position: Vec3, heading_rad: float, speed_mps: float = 0.0) -> State:
        """Return the state of a level vehicle that runs ahead, its propeller at the steady speed for that."""
        return self._running(position, heading_rad, speed_mps, self.steady_rpm(speed_mps))

    def _running(self, position: Vec3, heading_rad: float, speed_mps: float, propeller_rpm: float) -> State:
        attitude = quaternion_from_heading(heading_rad)
        return (*position, *attitude, speed_mps, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, propeller_rpm)

    def resting_command(self) -> Numbers:
        """Return fins amidships and a propeller at rest."""
        return (0.0, 0.0, 0.0)

    def limited_command(self, command: Numbers) -> Numbers:
        """Return rudder, stern plane (rad) and propeller (rpm) within their limits."""
        return self.params.servos.limited(command)

    def step(self, state: State, command: Numbers, current: Vec3, dt_s: float, steps: int = 1) -> State:
        """
        Return the state after `steps` steps of `dt_s`, the command held; the quaternion comes back with
        length 1.
        """
        return self._advance(state, command, current, self.numbers, dt_s, steps)

    def derivative(self, state: State, command: Numbers, current: Vec3) -> State:
        """Return the rate of change of the 16 floats of a state; see `_torpedo_body.motion`."""
        return self._rate(0.0, state, (command, current, self._body, self._water))

    def normalised(self, state: State) -> State:
        """Return the state with an attitude quaternion of length 1."""
        return normalised(state)


@cache
def _steady_speed_mps(model: Callable[[Any], TorpedoModel], params: Any, propeller_rpm: float) -> float:
    """Return `TorpedoModel.steady_speed_mps`; it is found once per process."""
    hull = model(params)
    return _root(lambda speed_mps: hull.ahead_mps2(speed_mps, propeller_rpm), 0.0, _FASTEST_MPS)


@cache
def _steady_rpm(model: Callable[[Any], TorpedoModel], params: Any, speed_mps: float) -> float:
    """Return `TorpedoModel.steady_rpm`; it is found once per process."""
    hull = model(params)
    return _root(lambda rpm: -hull.ahead_mps2(speed_mps, rpm), 0.0, params.servos.propeller_max_rpm)


@cache
def _turns(model: Callable[[Any], TorpedoModel], params: Any) -> tuple[Turn, ...]:
    """Return the turns of `TorpedoModel.turns`; they are flown once per process."""
    flown = model(params)
    least_rpm, most_rpm = flown.steady_rpm(params.least_speed_mps), params.servos.propeller_max_rpm
    step_rpm = (most_rpm - least_rpm) / (_TURNS - 1)
    return tuple(flown.flown_turn(least_rpm + step_rpm * number) for number in range(_TURNS))


def _root(falling: Callable[[float], float], low: float, high: float) -> float:
    """Return where a falling function is zero between two bounds, or the bound that it does not cross."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if falling(middle) > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
