"""
Vehicle models: the equations of motion. One file per structure; the parameters are in ``presets/*.yaml``.

To add a model with new equations, write one file here with

1. ``Params``: a frozen dataclass made of `auv_core.params.param` fields;
2. ``Model(params)``, a `VehicleModel`; a model whose rates are known at every instant is a `ContinuousModel`,
   which continuous-time runs integrate themselves. Its ``handling`` says what laws, checks and figures must
   know of the vehicle: whether it can stop, its least speed, its hull. A model that takes ``fins`` or
   ``thrusters`` has one `Actuator` with a state for each number of that command.

The file's name is its ``kind``. ``Params`` has ``frame`` if nu can be in another frame than the body's (see
`four_dof`). To add a vehicle with new numbers, write one file ``presets/<name>.yaml`` with ``kind`` and
``params``. The conformance tests check every model and preset found: finite, deterministic, inputs not
changed.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Protocol, runtime_checkable

from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Vec3
from auv_core.integrate import State
from auv_core.messages import Numbers, Vec6
from auv_core.params import ConfigError, Section
from auv_core.thrusters import Thrusters

HULL = 13
"""Numbers of a state that belong to the hull; the outputs of actuators follow them."""
_DRIVEN = ("fins", "thrusters")


class Handling(NamedTuple):
    """
    How a vehicle handles: what laws, checks and figures must not take from a hull that hovers.

    can_stop : whether it can hold a place.
    least_speed_mps : least speed through the water at which it obeys its command (m/s).
    hull_length_m, hull_diameter_m : length and diameter of the hull (m); equal for a sphere.
    near_m : distance from another hull's centre below which a report warns (m); 0 if only contact matters.
    """

    can_stop: bool
    least_speed_mps: float
    hull_length_m: float
    hull_diameter_m: float
    near_m: float = 0.0

    @property
    def hull_radius_m(self) -> float:
        """Radius of the sphere around the hull (m); two hulls touch at the sum of theirs."""
        return 0.5 * max(self.hull_length_m, self.hull_diameter_m)


class Actuator(NamedTuple):
    """An actuator whose output is part of a model's state: its name and the unit of its output."""

    name: str
    unit: str


class VehicleModel(Protocol):
    """
    Equations of motion.

    A state begins with 13 floats: NED position (m), attitude quaternion body to NED (w, x, y, z) and nu (m/s,
    rad/s; body FRD). The outputs of the `actuators` that have a state of their own follow them.
    """

    actuators: tuple[Actuator, ...] = ()

    @property
    def command(self) -> str:
        """What the vehicle takes, one of `auv_core.messages.COMMANDS`."""

    @property
    def handling(self) -> Handling:
        """How the vehicle handles."""

    @property
    def top_speed_mps(self) -> float:
        """Speed that the actuators hold against the drag (m/s); inf without a limit."""

    @property
    def longest_step_s(self) -> float:
        """Longest step with which `step` integrates this vehicle soundly (s); inf: any."""
        return math.inf

    def speed_held_mps(self, max_force_n: float) -> float:
        """Return the same for a controller with this limit along each axis (N)."""

    def turn_radius_m(self, speed_mps: float) -> float:
        """Return the radius of the tightest turn at a speed through the water (m); 0 if it turns in place."""
        return 0.0

    def initial_state(self, position: Vec3, heading_rad: float, speed_mps: float = 0.0) -> State:
        """Return the state of a level vehicle that runs ahead at a speed over ground (m/s)."""

    def resting_command(self) -> Numbers:
        """Return the numbers of the command with which the actuators rest."""
        return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def limited_command(self, command: Numbers) -> Numbers:
        """Return the actuators' output for a command, in the form of `auv_core.messages.command_numbers`."""

    def adrift(self) -> VehicleModel:
        """Return the model of this vehicle after the loss of its computer, such as without a drop weight."""
        return self

    def step(self, state: State, command: Numbers, current: Vec3, dt_s: float, steps: int = 1) -> State:
        """Return the state after `steps` steps of `dt_s` (s), with a constant command of the actuators."""


@runtime_checkable
class ContinuousModel(VehicleModel, Protocol):
    """A model whose rates are known at every instant."""

    def derivative(self, state: State, command: Numbers, current: Vec3) -> State:
        """Return the rate of change of a state for a command and a current (m/s; NED)."""

    def normalised(self, state: State) -> State:
        """Return the state with an attitude quaternion of length 1."""

    def kinetic_energy(self, nu: Vec6) -> float:
        """Return nu^T M nu / 2 (J)."""


@runtime_checkable
class _Framed(Protocol):
    frame: str


@runtime_checkable
class _Driven(Protocol):
    actuators: str
    thrusters: Thrusters


def make_model(section: Section) -> VehicleModel:
    """Return the model of a section."""
    made = class_of(__name__, section.kind, "Model")(section.params)
    contract = ContinuousModel if getattr(made, "command", None) == "wrench" else VehicleModel
    model: VehicleModel = fulfilled(made, contract)
    numbers = len(model.resting_command())
    if model.command in _DRIVEN and len(model.actuators) != numbers:
        raise ConfigError(
            f"{type(model).__module__}: {len(model.actuators)} actuators are not allowed; "
            f"allowed: one for each of the {numbers} numbers of the {model.command} command"
        )
    return model


def make_continuous_model(section: Section) -> ContinuousModel:
    """Return the model of a section for a run that integrates it."""
    model = make_model(section)
    if not isinstance(model, ContinuousModel):
        raise TypeError(f"a vehicle that takes a {model.command} and whose rates are not known")
    return model


def hovering(hull_radius_m: float) -> Handling:
    """Return the handling of a hull that can hold a place and turn in it."""
    diameter_m = 2.0 * hull_radius_m
    return Handling(can_stop=True, least_speed_mps=0.0, hull_length_m=diameter_m, hull_diameter_m=diameter_m)


def thrusters_of(section: Section) -> Thrusters:
    """Return the thrusters for which the vehicle of a section takes one force each, none if it does not."""
    params = section.params
    return (
        params.thrusters if isinstance(params, _Driven) and params.actuators == "thrusters" else Thrusters()
    )


def frame_of(params: Any) -> str:
    """Return the frame of nu of a model with these parameters."""
    return params.frame if isinstance(params, _Framed) else "body"
