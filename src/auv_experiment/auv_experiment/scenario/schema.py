"""
Scenarios: the data that define a run.

A scenario is one YAML file, `schema: 1`. `auv_experiment.scenario.loading` reads it strictly: an unknown,
missing, mistyped or impossible value is refused with one line that names its dotted path, the value and what
is allowed. The built-in scenarios are the files of ``auv_experiment/scenario``; a new file there adds a
scenario.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from auv_control.controllers import controller_class
from auv_control.references import ReferencePath, make_reference
from auv_core.geometry import Vec3
from auv_core.models import model_class
from auv_core.params import Section, param, shown
from auv_experiment.scenario.checks import check_scenario
from auv_experiment.scenario.file import ID, ID_WORDS
from auv_flocking.agent_config import (
    COMPACT,
    CONSENSUS,
    CONTROLLERS,
    FLOCKING,
    REFERENCES,
    REPORTS,
    SEPARATION,
)
from auv_flocking.input_limits import InputLimits
from auv_flocking.neighbours.table import NeighbourConfig
from auv_sim.acoustics.medium import MAC, MODEM, OUTAGE, PROPAGATION, SONAR, MediumConfig
from auv_sim.acoustics.sonar import none as no_sonar
from auv_sim.vehicle import EXACT, MODELS, NAVIGATION, substeps

MAX_M = 1e5


@dataclass(frozen=True, kw_only=True)
class Obstacle:
    """An obstacle: a point to avoid."""

    position_ned_m: Vec3 = param("position (m; NED)", minimum=-MAX_M, maximum=MAX_M)
    safety_distance_m: float = param(
        "distance at which vehicles begin to avoid it (m)", default=2.0, above=0.0
    )


@dataclass(frozen=True, kw_only=True)
class Environment:
    """The water and its obstacles."""

    current_ned_mps: Vec3 = param(
        "velocity of the water (m/s; NED)", default=(0.0, 0.0, 0.0), minimum=-5.0, maximum=5.0
    )
    obstacles: tuple[Obstacle, ...] = param("points to avoid, known to every vehicle", default=())
    navigation: Section = param("errors of the vehicles' own navigation", default=EXACT, plugins=NAVIGATION)


@dataclass(frozen=True, kw_only=True)
class VehicleEntry:
    """One vehicle of the scenario."""

    id: str = param("name, also the ROS namespace: a lower-case letter, then letters, digits, underscores")
    model: Section = param("equations of motion and numbers", plugins=MODELS)
    position_ned_m: Vec3 | None = param(
        "start (m; NED); if missing, drawn from random_starts",
        default=None,
        minimum=-MAX_M,
        maximum=MAX_M,
    )
    heading_rad: float = param(
        "start heading (rad, from north towards east)", default=0.0, minimum=-7.0, maximum=7.0
    )
    reference: Section | None = param(
        "path of this vehicle; if missing, the path of the scenario", default=None, plugins=REFERENCES
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
    """Random starts drawn with the seed: uniform in a ball, apart from each other and below the surface."""

    centre_ned_m: Vec3 = param("centre of the ball (m; NED)", minimum=-MAX_M, maximum=MAX_M)
    radius_m: float = param("radius of the ball (m)", above=0.0, maximum=MAX_M)
    separation_m: float = param("smallest distance between two starts (m)", above=0.0)
    depth_min_m: float = param("smallest depth (m)", default=1.0, minimum=0.0)


@dataclass(frozen=True, kw_only=True)
class Acoustics:
    """The acoustic medium."""

    preset: str = param("file of presets/ that fills in the missing sections", default="")
    propagation: Section = param("travel time", plugins=PROPAGATION)
    modem: Section = param("duration and range of packets", plugins=MODEM)
    mac: Section = param("medium access", plugins=MAC)
    outage: Section = param("further random losses", plugins=OUTAGE)
    sonar: Section = param(
        "how vehicles detect each other by sonar", default=Section("none", no_sonar.Params()), plugins=SONAR
    )


@dataclass(frozen=True, kw_only=True)
class AgentSettings:
    """
    The software of every vehicle: either a controller that follows the velocity command of a flocking law
    with separation and consensus, or a controller that follows a path or a region itself.
    """

    controller: Section = param("control law from velocity, path or region to command", plugins=CONTROLLERS)
    flocking: Section | None = param("flocking law", default=None, plugins=FLOCKING)
    separation: Section | None = param("separation law", default=None, plugins=SEPARATION)
    consensus: Section | None = param(
        "consensus filter of the flocking centre", default=None, plugins=CONSENSUS
    )
    report: Section = param("format of a report", default=COMPACT, plugins=REPORTS)
    neighbours: NeighbourConfig = param("neighbour filters", default=NeighbourConfig())
    inputs: InputLimits = param(
        "limits beyond which inputs are ignored as too old or impossible", default=InputLimits()
    )
    hold_s: float = param(
        "longest time to hold station while waiting for a first packet from every neighbour (s)",
        default=0.0,
        minimum=0.0,
    )


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
    agent: AgentSettings = param("the software of every vehicle")
    acoustics: Acoustics = param("the acoustic medium")
    readings: tuple[Reading, ...] = param("path errors to report at given instants", default=())
    environment: Environment = param("the water and its obstacles", default=Environment())
    random_starts: RandomStarts | None = param("random starts for vehicles without a start", default=None)
    seed: int = param("seed of every random number", default=1, minimum=0, maximum=2**31 - 1)
    dt_s: float = param("physics step (s)", default=0.02, minimum=1e-5, maximum=10.0)
    period_s: float = param(
        "control period (s), a whole number of physics steps", default=0.1, minimum=1e-5, maximum=10.0
    )
    sampling: str = param(
        "whether commands are held over the control period (sampled) or evaluated in every integration "
        "stage (continuous)",
        default="sampled",
        choices=("sampled", "continuous"),
    )
    on_vehicle_loss: str = param(
        "what to do if a vehicle is lost", default="stop", choices=("stop", "continue")
    )
    command_max_age_s: float = param(
        "age of a command above which the actuators stop (s); at least two control periods",
        default=0.5,
        above=0.0,
    )
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
    def hull_radius_m(self) -> float:
        """Largest hull radius of the fleet (m)."""
        return max(vehicle.model.params.hull_radius_m for vehicle in self.vehicles)

    @property
    def kinematic(self) -> bool:
        """Whether the vehicles take velocity commands."""
        return model_class(self.vehicles[0].model.kind).command == "velocity"

    @property
    def medium_config(self) -> MediumConfig:
        """Configuration of the acoustic medium."""
        a = self.acoustics
        return MediumConfig(
            fleet_size=len(self.vehicles),
            seed=self.seed,
            period_s=self.period_s,
            propagation=a.propagation,
            modem=a.modem,
            mac=a.mac,
            outage=a.outage,
            sonar=a.sonar,
        )

    def reference_of(self, index: int | None = None) -> ReferencePath | None:
        """Return the path of a vehicle, or of the flock: a ``Reference`` of the plugin folder, or None."""
        section = None if index is None else self.vehicles[index].reference
        section = self.reference if section is None else section
        return None if section is None else make_reference(section)

    @property
    def follows(self) -> str:
        """What the controllers follow: velocity (of a flocking law), path or region."""
        return controller_class(self.agent.controller.kind).follows
