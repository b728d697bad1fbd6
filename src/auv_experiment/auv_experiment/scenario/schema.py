"""
Scenarios: the data that define a run.

A scenario is one YAML file, `schema: 1`. `auv_experiment.scenario.loading` reads it strictly: an unknown,
missing, mistyped or impossible value is refused with one line that names its dotted path, the value and what
is allowed. The built-in scenarios are the files of ``auv_experiment/scenario``; a new file there adds a
scenario.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from auv_control.controllers import controller_class
from auv_control.references import ReferencePath, make_reference
from auv_core.geometry import Vec3
from auv_core.models import Handling, make_model
from auv_core.params import Section, extended, param, same, shown
from auv_core.run_settings import RunSettings
from auv_core.thrusters import ThrusterFault
from auv_experiment.scenario.checks import check_scenario
from auv_experiment.scenario.file import ID, ID_WORDS
from auv_experiment.scenario.random_starts import DEPTHS
from auv_flocking.agent_config import FOLLOW_REFERENCE, REFERENCES, AgentSettings
from auv_sim.acoustics.medium import MediumConfig, WaterSections
from auv_sim.obstacle_field import MAX_M, ObstacleConfig
from auv_sim.vehicle import VehicleConfig, substeps


@dataclass(frozen=True, kw_only=True)
class Obstacle(ObstacleConfig):
    """An obstacle: a point to avoid."""

    safety_distance_m: float = param(
        "distance at which vehicles that know it begin to avoid it (m)", default=2.0, above=0.0
    )

    def __post_init__(self) -> None:
        """Refuse a moving obstacle that is known: vehicles are not told its motion."""
        if self.known and self.is_moving:
            raise ValueError(
                f"known: True is not allowed for the motion {self.motion.kind}; "
                "allowed: False, since vehicles know positions only"
            )


@dataclass(frozen=True, kw_only=True)
class Environment:
    """The water and its obstacles."""

    current_ned_mps: Vec3 = same(VehicleConfig, "current_ned_mps")
    current: Section = same(VehicleConfig, "current")
    obstacles: tuple[Obstacle, ...] = param("points to avoid, known or to be sensed", default=())
    navigation: Section = same(VehicleConfig, "navigation")


@dataclass(frozen=True, kw_only=True)
class VehicleEntry:
    """One vehicle of the scenario."""

    id: str = param("name, also the ROS namespace: a lower-case letter, then letters, digits, underscores")
    model: Section = same(VehicleConfig, "model")
    position_ned_m: Vec3 | None = param(
        "start (m; NED); if missing, drawn from random_starts",
        default=None,
        minimum=-MAX_M,
        maximum=MAX_M,
    )
    heading_rad: float = same(VehicleConfig, "heading_rad")
    speed_mps: float = same(VehicleConfig, "speed_mps")
    fails_at_s: float | None = same(RunSettings, "fails_at_s")
    fault: ThrusterFault = same(VehicleConfig, "fault")
    propeller_limit_rpm: float | None = same(VehicleConfig, "propeller_limit_rpm")
    reference: Section | None = param(
        "path of this vehicle; if missing, the path of the scenario", default=None, plugins=REFERENCES
    )
    agent: AgentSettings | None = param(
        "software of this vehicle: what differs from the section `agent` of the scenario", default=None
    )


@dataclass(frozen=True, kw_only=True)
class Reading:
    """One component of the first vehicle's path error at one instant, as a separate metric."""

    axis: str = param("NED axis", choices=("x", "y", "z"))
    time_s: float = param("scenario time, a multiple of 0.1 s (s)", minimum=0.0, maximum=1e6)

    @property
    def key(self) -> str:
        """Name of the metric, such as ``x_err_5p4_m``."""
        return f"{self.axis}_err_{self.time_s:.1f}_m".replace(".", "p")


@dataclass(frozen=True, kw_only=True)
class RandomStarts:
    """Random starts drawn with the seed: uniform in a ball or a disc, apart, and below the surface."""

    centre_ned_m: Vec3 = param("centre of the ball or disc (m; NED)", minimum=-MAX_M, maximum=MAX_M)
    radius_m: float = param("radius of the ball or disc (m)", above=0.0, maximum=MAX_M)
    separation_m: float = param("smallest distance between two starts (m), in a disc on the map", above=0.0)
    depth_min_m: float = param("smallest depth (m)", default=1.0, minimum=0.0)
    depths: str = param(
        "ball: drawn in a ball; centre: a disc at the depth of the centre; layers: a disc, each vehicle at "
        "the depth of its layer in agent.fleet",
        default="ball",
        choices=DEPTHS,
    )
    any_heading: bool = param("whether headings are drawn, uniform over the circle", default=False)
    speed_mps: float = param(
        "speed ahead over ground of vehicles that cannot stop and have none of their own, whose headings are "
        "drawn then too (m/s)",
        default=1.5,
        minimum=0.0,
    )
    in_depth_order: bool = param(
        "whether the starts of a ball are given out by depth, the highest to the first vehicle", default=False
    )


@dataclass(frozen=True, kw_only=True)
class Acoustics(WaterSections):
    """The acoustic medium."""

    preset: str = param("file of presets/ that fills in the missing sections", default="")


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """Everything that determines a run; with the same seed it determines every number."""

    schema: int = param("version of this format", minimum=1, maximum=1)
    name: str = param("name, also of results and bags")
    title: str = param("description in one line")
    duration_s: float = param(
        "length of the run (s), a whole number of control periods", above=0.0, maximum=1e6
    )
    vehicles: tuple[VehicleEntry, ...] = param(
        "the vehicles, or {count: N} with their common properties; their order gives the acoustic "
        "addresses 1, 2, ..."
    )
    leaders: tuple[str, ...] = param(
        "ids of the vehicles that know the path of a flock, or `all`", default=()
    )
    reference: Section | None = param("path to follow", default=None, plugins=REFERENCES)
    agent: AgentSettings = param("the software of every vehicle, but for what vehicles have of their own")
    acoustics: Acoustics = param("the acoustic medium")
    readings: tuple[Reading, ...] = param("path errors to report at given instants", default=())
    environment: Environment = param("the water and its obstacles", default=Environment())
    random_starts: RandomStarts | None = param("random starts for vehicles without a start", default=None)
    seed: int = same(RunSettings, "seed")
    dt_s: float = same(RunSettings, "dt_s")
    period_s: float = same(RunSettings, "period_s")
    sampling: str = param(
        "whether commands are held over the control period (sampled) or evaluated in every integration "
        "stage (continuous)",
        default="sampled",
        choices=("sampled", "continuous"),
    )
    on_vehicle_loss: str = param(
        "what to do if a vehicle is lost", default="stop", choices=("stop", "continue")
    )
    command_max_age_s: float = same(VehicleConfig, "command_max_age_s")
    state_max_age_s: float = param(
        "age of a vehicle's state above which its modem is silent (s); at least two control periods",
        default=0.5,
        above=0.0,
    )
    answer_timeout_s: float = param(
        "wall time without an answer after which a node counts as lost (s)",
        default=3.0,
        minimum=0.5,
        maximum=600.0,
    )

    def __post_init__(self) -> None:
        """Check values against each other; messages begin with the field."""
        if not ID.match(self.name):
            raise ValueError(f"name: {shown(self.name)} is not allowed; allowed: {ID_WORDS}")
        if not self.title.isprintable():
            raise ValueError(f"title: {shown(self.title)} is not allowed; allowed: one line of text")
        substeps(self.period_s, self.dt_s)
        ticks = self.duration_s / self.period_s
        if round(ticks) < 1 or abs(ticks - round(ticks)) > 1e-6:
            raise ValueError(
                f"duration_s: {self.duration_s!r} is not allowed; allowed: a whole "
                f"multiple of period_s = {self.period_s!r}"
            )
        check_scenario(self)

    @property
    def ticks(self) -> int:
        """Number K of control periods."""
        return round(self.duration_s / self.period_s)

    def tick_times(self) -> NDArray[np.float64]:
        """Return the scenario times of the ticks 0 ... K (s)."""
        return np.arange(self.ticks + 1, dtype=np.float64) * self.period_s

    @property
    def handlings(self) -> tuple[Handling, ...]:
        """How each vehicle handles."""
        return tuple(make_model(vehicle.model).handling for vehicle in self.vehicles)

    @property
    def hull_radius_m(self) -> float:
        """Largest hull radius of the fleet (m)."""
        return max(self.hull_radii_m)

    @property
    def hull_radii_m(self) -> tuple[float, ...]:
        """Radius of the sphere around the hull of each vehicle (m)."""
        return tuple(handling.hull_radius_m for handling in self.handlings)

    @property
    def kinematic(self) -> bool:
        """Whether all vehicles take velocity commands."""
        return set(self.commands) == {"velocity"}

    @property
    def commands(self) -> tuple[str, ...]:
        """The kind of command that each vehicle takes."""
        return tuple(make_model(vehicle.model).command for vehicle in self.vehicles)

    @property
    def medium_config(self) -> MediumConfig:
        """Configuration of the acoustic medium."""
        return extended(MediumConfig, self.acoustics, self, fleet_size=len(self.vehicles))

    @cached_property
    def agents(self) -> tuple[AgentSettings, ...]:
        """The software of each vehicle."""
        return tuple(self.agent if vehicle.agent is None else vehicle.agent for vehicle in self.vehicles)

    @property
    def follows(self) -> str:
        """
        What the controllers of a team follow: velocity (of a flocking law), path, region or course; see
        `auv_experiment.scenario.teams`.
        """
        return self.follows_of(0)

    def follows_of(self, index: int) -> str:
        """Return what the controller of a vehicle follows."""
        return controller_class(self.agents[index].controller.kind).follows

    def reference_section(self, index: int) -> Section | None:
        """
        Return the path of a vehicle, or None: its own, or that of the scenario if its controller follows one
        and another vehicle's does not.
        """
        own = self.vehicles[index].reference
        if own is not None or self.reference is None or self.follows_of(index) in FOLLOW_REFERENCE:
            return self.reference if own is None else own
        others = range(len(self.vehicles))
        return None if any(self.follows_of(other) in FOLLOW_REFERENCE for other in others) else self.reference

    def reference_of(self, index: int | None = None) -> ReferencePath | None:
        """Return the path of a vehicle, or of the flock: a ``Reference`` of the plugin folder, or None."""
        section = self.reference if index is None else self.reference_section(index)
        return None if section is None else make_reference(section)
