"""
Fleets of vehicles that cannot stop: what each does for the group, above the autopilots.

To add one, write one file with ``Params`` and ``Fleet(params, member, controller, period_s, mission)``, a
`FleetTask`. The file's name is its ``kind``.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol, runtime_checkable

from auv_control.controllers import CourseController, VelocityReference
from auv_control.guidance.feasibility import Turning
from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Box, Vec3
from auv_core.messages import FinCommand, VehicleState
from auv_core.params import Section
from auv_flocking.codec import Field
from auv_flocking.flocking import FlockVelocity, Member
from auv_flocking.neighbours.estimates import Neighbours


class Start(NamedTuple):
    """Where a vehicle starts (m; NED), its heading (rad), and its speed ahead over ground (m/s)."""

    position_ned_m: Vec3
    heading_rad: float
    speed_mps: float


class Mission(NamedTuple):
    """
    What every vehicle is told before the mission.

    starts : where each vehicle starts, in the order of addresses; empty: not known.
    cycle_s : time between two own slots of the channel (s); None: the medium access has no cycle.
    """

    starts: tuple[Start, ...] = ()
    cycle_s: float | None = None


@runtime_checkable
class FleetTask(Protocol):
    """
    The task of one vehicle, stepped once per control period; it keeps its own state.

    `shared_fields` are the fields that it adds to every report, `safe_command` what it gives without a usable
    navigation. After a step: `law_state` (its numbers for a recording), `reference` (velocity and heading
    that it asks for), `centre`, `centre_rate` and `flock_velocity`, which a fleet without a flocking centre
    leaves at its position, zero and unknown.
    """

    shared_fields: tuple[Field, ...]
    safe_command: FinCommand
    law_state: tuple[float, ...]
    reference: VelocityReference
    centre: Vec3
    centre_rate: Vec3
    flock_velocity: FlockVelocity

    def step(
        self, t_s: float, nav: VehicleState, neighbours: Neighbours, others: Neighbours = ()
    ) -> FinCommand:
        """Return the command of one control period; `others` have no part in the task."""

    def check(self, vehicle: Turning, current_mps: float) -> None:
        """Raise ValueError unless the vehicle can do its part in a current of any direction (m/s)."""

    def reach(self) -> Box | None:
        """Return a box around where the vehicle can be once it is on its way (m; NED), None if unknown."""
        return None

    def shared(self) -> tuple[float, ...]:
        """Return the numbers that this task adds to a packet after a step."""

    def sends(self, t_s: float) -> bool:
        """Return whether the vehicle uses an own slot of the channel at `t_s` (s), after a step."""


@runtime_checkable
class LayeredFleet(Protocol):
    """Parameters of a fleet in which every vehicle has a layer of depth."""

    def layer_depths(self, fleet_size: int) -> tuple[float, ...]:
        """Return the depth of each vehicle's layer (m), in the order of addresses."""


def has_layers(section: Section | None) -> bool:
    """Return whether the section is a fleet in which every vehicle has a layer of depth."""
    return section is not None and isinstance(section.params, LayeredFleet)


def layers_of(section: Section | None, fleet_size: int) -> tuple[float, ...]:
    """Return the depth of each vehicle's layer (m) in a fleet that has layers."""
    if section is None or not isinstance(section.params, LayeredFleet):
        raise RuntimeError("a fleet without layers of depth: the scenario should have refused it")
    return section.params.layer_depths(fleet_size)


def make_fleet(
    section: Section, member: Member, controller: CourseController, period_s: float, mission: Mission
) -> FleetTask:
    """Return the task of a section for one vehicle, for a control period (s)."""
    made = class_of(__name__, section.kind, "Fleet")(section.params, member, controller, period_s, mission)
    task: FleetTask = fulfilled(made, FleetTask)
    return task


def fields_of(section: Section) -> tuple[Field, ...]:
    """Return the fields that the task of a section adds to every report."""
    fields: tuple[Field, ...] = class_of(__name__, section.kind, "Fleet").shared_fields
    return fields
