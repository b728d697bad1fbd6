"""
Controllers: they compute the command of one vehicle's actuators.

To add one, write one file with ``Params`` and ``Controller(params, period_s)``. The file's name is its
``kind``. Its attribute ``command`` (``'wrench'``, ``'velocity'`` or ``'fins'``) is the kind of its output,
which the vehicle's model must take. Its attribute ``follows`` is the kind of its input:

``follows = 'velocity'``
    The inner loop under a flocking law: a `VelocityController`, or one that can run in continuous time as
    well, a `ContinuousVelocityController`.

``follows = 'course'``
    Autopilots of a vehicle with fins, under a course of the folder ``courses``: a `CourseController`.

``follows = 'path'`` or ``'region'``
    A law that computes the wrench directly from the `MotionView` of one instant: a `MotionLaw` or a
    `RegionLaw`. With ``'region'`` the view's path is None. The law is pure. Its state (parameter estimates,
    integral states) is a tuple of floats that the caller keeps and integrates, so that the sampled agent and
    the continuous-time runner use the same law.

    ``Params`` has ``frame`` if the law supports several frames of the plant (see `models/four_dof.py`), and
    ``max_force_n`` if the law limits the force along each axis (N).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Protocol, runtime_checkable

from auv_control.courses import Guided
from auv_control.references import PathPoint
from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Box, Quat, Vec3
from auv_core.integrate import State
from auv_core.messages import Command, FinCommand, Vec6, VehicleState
from auv_core.params import Section


class VelocityReference(NamedTuple):
    """The command of a flocking law: velocity over ground (m/s; NED) and heading (rad)."""

    velocity: Vec3
    heading_rad: float


@dataclass(frozen=True, slots=True)
class MotionView:
    """
    The information of one vehicle at one instant.

    Own navigation, the path point (None for a law that follows no path), the positions of the neighbours
    (m; NED; as estimated) and the obstacles with their safety distances (m; NED).
    """

    t_s: float
    nav: VehicleState
    path: PathPoint | None
    neighbours: tuple[Vec3, ...] = ()
    obstacles: tuple[tuple[Vec3, float], ...] = ()


@runtime_checkable
class VelocityController(Protocol):
    """The inner loop under a flocking law."""

    command: ClassVar[str]
    follows: ClassVar[str]

    def step(self, nav: VehicleState, reference: VelocityReference) -> Command:
        """Return the command of one control period, from the vehicle's own navigation."""


@runtime_checkable
class ContinuousVelocityController(VelocityController, Protocol):
    """An inner loop whose integral state of three numbers the caller can keep."""

    def evaluate(
        self, attitude: Quat, nu: Vec6, integral: Vec3, reference: VelocityReference
    ) -> tuple[Vec6, Vec3]:
        """Return the wrench at one instant (N, N m; body) and the rate of the integral state."""


@runtime_checkable
class CourseController(Protocol):
    """
    Autopilots under a course.

    `safe_command` is what they give without a usable navigation, `state` the numbers that they keep.
    """

    command: ClassVar[str]
    follows: ClassVar[str]
    safe_command: FinCommand

    @property
    def state(self) -> State:
        """Integral states and so on, `()` before the first step."""

    def step(self, nav: VehicleState, guided: Guided) -> FinCommand:
        """Return the command of one control period, from the vehicle's own navigation and its course."""


@runtime_checkable
class MotionLaw(Protocol):
    """
    A law that computes the wrench directly.

    `candidates` are the names of its Lyapunov candidates, and `shared_candidate` tells whether their values
    are shares, whose sum over the vehicles is the candidate. `proof_gap` says in one sentence why the
    printed proof does not cover a run in which V increases.
    """

    command: ClassVar[str]
    follows: ClassVar[str]
    candidates: ClassVar[tuple[str, ...]]
    shared_candidate: ClassVar[bool]
    proof_gap: str

    def initial_state(self, view: MotionView) -> State:
        """Return the initial state of the law, `()` for a law without state."""

    def evaluate(self, state: State, view: MotionView) -> tuple[Vec6, State]:
        """Return the wrench (N, N m; body FRD) and the rate of `state` per second."""

    def constrained(self, state: State) -> State:
        """Return `state` projected to allowed values, after each step; as it is if all are allowed."""
        return state

    def lyapunov(
        self, state: State, view: MotionView, kinetic_energy: Callable[[Vec6], float]
    ) -> tuple[float, ...]:
        """Return the candidates' values; `kinetic_energy` is the plant's nu^T M nu / 2 (J) of nu."""


@runtime_checkable
class RegionLaw(MotionLaw, Protocol):
    """A law that follows a region; `region` is a box around it (m; NED)."""

    region: Box


Controller = VelocityController | MotionLaw | CourseController
ControllerClass = type[VelocityController] | type[MotionLaw] | type[CourseController]


@runtime_checkable
class _Framed(Protocol):
    frame: str


@runtime_checkable
class _Bounded(Protocol):
    max_force_n: float | None


def controller_class(kind: str) -> ControllerClass:
    """Return the class of the controller of a kind."""
    found: ControllerClass = class_of(__name__, kind, "Controller")
    return found


def contract_of(kind: str) -> type:
    """Return the protocol of a kind, which depends on what it follows."""
    follows = controller_class(kind).follows
    contracts = {"velocity": VelocityController, "region": RegionLaw, "course": CourseController}
    return contracts.get(follows, MotionLaw)


def make_controller(section: Section, period_s: float) -> Controller:
    """Return the controller of a section, for a control period (s)."""
    made = class_of(__name__, section.kind, "Controller")(section.params, period_s)
    controller: Controller = fulfilled(made, contract_of(section.kind))
    return controller


def region_of(section: Section, period_s: float) -> Box | None:
    """
    Return a box around the region that a section's controller follows (m; NED), None for other controllers.
    """
    controller = make_controller(section, period_s)
    return controller.region if isinstance(controller, RegionLaw) else None


def frame_of(params: Any) -> str | None:
    """Return the frame that a law with these parameters is written for, None for any."""
    return params.frame if isinstance(params, _Framed) else None


def max_force_of(params: Any) -> float:
    """Return the force limit along each axis of a controller with these parameters (N; inf: no limit)."""
    if isinstance(params, _Bounded) and params.max_force_n is not None:
        return params.max_force_n
    return math.inf
