"""
Vehicle models: the equations of motion. One file per structure; the parameters are in ``presets/*.yaml``.

To add a model with new equations, write one file here with

1. ``Params``: a frozen dataclass made of `auv_core.params.param` fields, with at least ``hull_radius_m``;
2. ``Model(params)``, a `VehicleModel`; a model that takes a wrench is a `WrenchModel`, which continuous-time
   runs integrate themselves.

The file's name is its ``kind``. ``Params`` has ``frame`` if nu can be in another frame than the body's (see
`four_dof`). To add a vehicle with new numbers, write one file ``presets/<name>.yaml`` with ``kind`` and
``params``. The conformance tests check every model and preset found: finite, deterministic, inputs not
changed.
"""

from __future__ import annotations

from typing import Any, ClassVar, Protocol, runtime_checkable

from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Vec3
from auv_core.integrate import State
from auv_core.messages import Vec6
from auv_core.params import Section


class VehicleModel(Protocol):
    """
    Equations of motion on the 13 floats of a state.

    They are NED position (m), attitude quaternion body to NED (w, x, y, z) and nu (m/s, rad/s; body FRD).
    `command` is ``'wrench'`` or ``'velocity'``, what the vehicle takes.
    """

    command: ClassVar[str]

    @property
    def top_speed_mps(self) -> float:
        """Speed that the actuators hold against the drag (m/s); inf without a limit."""

    def speed_held_mps(self, max_force_n: float) -> float:
        """Return the same for a controller with this limit along each axis (N)."""

    def initial_state(self, position: Vec3, heading_rad: float) -> State:
        """Return the state of a level vehicle at rest."""

    def limited_command(self, command: Vec6) -> Vec6:
        """Return the actuators' output for a command, in the form of `auv_core.messages.command_numbers`."""

    def step(self, state: State, command: Vec6, current: Vec3, dt_s: float, steps: int = 1) -> State:
        """Return the state after `steps` steps of `dt_s` (s), with a constant output of the actuators."""


@runtime_checkable
class WrenchModel(VehicleModel, Protocol):
    """A model that takes a wrench (N, N m; body)."""

    def derivative(self, state: State, tau: Vec6, current: Vec3) -> State:
        """Return the rate of change of a state for a wrench and a current (m/s; NED)."""

    def normalised(self, state: State) -> State:
        """Return the state with an attitude quaternion of length 1."""

    def kinetic_energy(self, nu: Vec6) -> float:
        """Return nu^T M nu / 2 (J)."""


@runtime_checkable
class _Framed(Protocol):
    frame: str


def model_class(kind: str) -> type[VehicleModel]:
    """Return the class of the model of a kind."""
    found: type[VehicleModel] = class_of(__name__, kind, "Model")
    return found


def make_model(section: Section) -> VehicleModel:
    """Return the model of a section."""
    made = class_of(__name__, section.kind, "Model")(section.params)
    model: VehicleModel = fulfilled(made, VehicleModel if made.command == "velocity" else WrenchModel)
    return model


def make_wrench_model(section: Section) -> WrenchModel:
    """Return the model of a section whose vehicle takes a wrench."""
    model = make_model(section)
    if not isinstance(model, WrenchModel):
        raise TypeError(f"a vehicle that takes a {model.command}")
    return model


def frame_of(params: Any) -> str:
    """Return the frame of nu of a model with these parameters."""
    return params.frame if isinstance(params, _Framed) else "body"
