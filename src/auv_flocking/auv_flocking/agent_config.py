"""Configuration of an agent: its settings, the plugin folders of its parts, and which parts fit together."""

from __future__ import annotations

from dataclasses import dataclass

from auv_control.allocation import qp
from auv_control.controllers import controller_class
from auv_core.params import Section, extended, param, same
from auv_core.run_settings import RunSettings
from auv_core.thrusters import ThrusterFault, Thrusters
from auv_flocking.consensus import make_consensus
from auv_flocking.fleets import Mission, Start, fields_of
from auv_flocking.flock_task import Obstacles
from auv_flocking.input_limits import InputLimits
from auv_flocking.neighbours.table import NeighbourConfig
from auv_flocking.report_reader import ReportReader
from auv_flocking.reports import ReportDecoder, ReportFormat, compact, make_format
from auv_flocking.trackers import none

REFERENCES = "auv_control.references"
CONTROLLERS = "auv_control.controllers"
COURSES = "auv_control.courses"
ALLOCATION = "auv_control.allocation"
FLEETS = "auv_flocking.fleets"
FLOCKING = "auv_flocking.flocking"
SEPARATION = "auv_flocking.separation"
CONSENSUS = "auv_flocking.consensus"
REPORTS = "auv_flocking.reports"
OBSTACLE_TRACKERS = "auv_flocking.trackers"
COMPACT = Section("compact", compact.Params())
NO_TRACKER = Section("none", none.Params())
QUADRATIC_PROGRAM = Section("qp", qp.Params())


@dataclass(frozen=True, kw_only=True)
class AgentSettings:
    """
    Section `agent` of a scenario.

    The software of a vehicle: a controller that follows the velocity command of a flocking law with
    separation and consensus, one that follows a path or a region itself, or one that follows a course.
    """

    controller: Section = param("control law from velocity, path or region to command", plugins=CONTROLLERS)
    course: Section | None = param(
        "what gives heading, depth and speed, for a controller that follows a course",
        default=None,
        plugins=COURSES,
    )
    fleet: Section | None = param(
        "what vehicles that cannot stop do together, instead of a course of its own for each",
        default=None,
        plugins=FLEETS,
    )
    allocation: Section = param(
        "how the forces of thrusters are chosen for a wrench, for vehicles with thrusters",
        default=QUADRATIC_PROGRAM,
        plugins=ALLOCATION,
    )
    flocking: Section | None = param(
        "flocking law, for a controller that follows a velocity", default=None, plugins=FLOCKING
    )
    separation: Section | None = param("separation law", default=None, plugins=SEPARATION)
    consensus: Section | None = param(
        "consensus filter of the flocking centre", default=None, plugins=CONSENSUS
    )
    report: Section = param("format of a report", default=COMPACT, plugins=REPORTS)
    neighbours: NeighbourConfig = param("neighbour filters", default=NeighbourConfig())
    obstacle_tracker: Section = param(
        "what to make of sonar contacts of no neighbour", default=NO_TRACKER, plugins=OBSTACLE_TRACKERS
    )
    inputs: InputLimits = param(
        "limits beyond which inputs are ignored as too old or impossible", default=InputLimits()
    )
    hold_s: float = param(
        "longest time to hold station while waiting for a first packet from every neighbour (s)",
        default=0.0,
        minimum=0.0,
    )
    clearance_m: float = param(
        "distance at which a flock's vehicle begins to avoid one with another task (m); it keeps 0.65 of it",
        default=8.0,
        above=0.0,
    )


@dataclass(frozen=True, kw_only=True)
class SpokenReport:
    """What determines the bytes of a vehicle's reports: the format, and what its task adds."""

    report: Section = same(AgentSettings, "report")
    fleet: Section | None = same(AgentSettings, "fleet")
    consensus: Section | None = same(AgentSettings, "consensus")

    @classmethod
    def of(cls, agent: AgentSettings) -> SpokenReport:
        """Return the reports of an agent."""
        return extended(cls, agent)

    def format(self, fleet_size: int) -> ReportFormat:
        """Return their format."""
        if self.fleet is not None:
            return make_format(self.report, fields_of(self.fleet))
        consensus = self.consensus
        shared_fields = () if consensus is None else make_consensus(consensus, fleet_size).shared_fields
        return make_format(self.report, shared_fields)

    def bytes_of(self, fleet_size: int) -> object:
        """Return what two reports of a kind have alike if their bytes mean the same."""
        return self.report, self.format(fleet_size).budget


@dataclass(frozen=True, kw_only=True)
class AgentConfig(AgentSettings):
    """Configuration of one agent: the section of the scenario, and what belongs to one vehicle."""

    vehicle_id: str = param("name of the vehicle, also its namespace")
    address: int = param("acoustic address of this vehicle, from 1", minimum=1, maximum=254)
    fleet_size: int = param("number of vehicles", minimum=1, maximum=254)
    fleet_ids: tuple[str, ...] = param(
        "names of the vehicles in the order of their addresses, for messages", default=()
    )
    group: tuple[int, ...] = param(
        "addresses of the vehicles that do the same task together; empty: all",
        default=(),
        minimum=1,
        maximum=254,
    )
    heard_reports: tuple[SpokenReport, ...] = param(
        "reports of vehicles with other tasks, if they differ from the own", default=()
    )
    is_leader: bool = param("whether this vehicle knows the path", default=False)
    fails_at_s: float | None = same(RunSettings, "fails_at_s")
    period_s: float = same(RunSettings, "period_s")
    has_sonar: bool = param(
        "whether this vehicle has a sonar; without one it ignores sonar contacts", default=True
    )
    obstacles_ned_m: tuple[float, ...] = param(
        "positions of known obstacles, three numbers each (m; NED)", default=()
    )
    obstacle_safety_distances_m: tuple[float, ...] = param(
        "safety distance of each obstacle (m)", default=(), above=0.0
    )
    reference: Section | None = param("path to follow, if any", default=None, plugins=REFERENCES)
    thrusters: Thrusters = param("the vehicle's thrusters, if it takes a force for each", default=Thrusters())
    fault: ThrusterFault = param("fault of a thruster", default=ThrusterFault())
    cycle_s: float | None = param(
        "time between two own slots of the channel (s); null: the medium access has no cycle", default=None
    )
    starts_ned_m: tuple[float, ...] = param(
        "where the vehicles of a fleet start, three numbers each in the order of addresses (m; NED)",
        default=(),
    )
    start_headings_rad: tuple[float, ...] = param("their headings (rad)", default=())
    start_speeds_mps: tuple[float, ...] = param("their speeds ahead over ground (m/s)", default=())

    def __post_init__(self) -> None:
        check_parts(self, self.reference)
        if len(self.fleet_ids) not in (0, self.fleet_size):
            raise ValueError(
                f"fleet_ids: {len(self.fleet_ids)} names are not allowed; allowed: {self.fleet_size}, or none"
            )
        if not len(self.starts_ned_m) == 3 * len(self.start_headings_rad) == 3 * len(self.start_speeds_mps):
            raise ValueError(
                f"starts_ned_m: {len(self.starts_ned_m)} numbers are not allowed; allowed: three for each of "
                f"the {len(self.start_headings_rad)} headings and {len(self.start_speeds_mps)} speeds"
            )
        if self.group and self.address not in self.group:
            raise ValueError(
                f"group: {list(self.group)} is not allowed; allowed: addresses with the own {self.address}"
            )
        if len(self.obstacles_ned_m) != 3 * len(self.obstacle_safety_distances_m):
            raise ValueError(
                f"obstacles_ned_m: {len(self.obstacles_ned_m)} numbers are not allowed; "
                "allowed: three for each of the "
                f"{len(self.obstacle_safety_distances_m)} safety distances"
            )

    @property
    def obstacles(self) -> Obstacles:
        """Positions of the known obstacles (m; NED) with their safety distances (m)."""
        x = self.obstacles_ned_m
        return tuple(
            ((x[3 * i], x[3 * i + 1], x[3 * i + 2]), safety_distance_m)
            for i, safety_distance_m in enumerate(self.obstacle_safety_distances_m)
        )

    @property
    def mission(self) -> Mission:
        """What the vehicle of a fleet is told before the mission."""
        x = self.starts_ned_m
        poses = zip(self.start_headings_rad, self.start_speeds_mps, strict=True)
        starts = tuple(
            Start((x[3 * i], x[3 * i + 1], x[3 * i + 2]), heading_rad, speed_mps)
            for i, (heading_rad, speed_mps) in enumerate(poses)
        )
        return Mission(starts, self.cycle_s)


FOLLOW_REFERENCE = ("velocity", "path")
"""What controllers follow that need a path of the folder `references`."""
PARTS = {"velocity": ("flocking", "separation", "consensus"), "course": ("course",)}
"""The parts that a controller needs, by what it follows; a path or a region needs none."""


def check_parts(agent: AgentSettings, reference: Section | None, *, where: str = "", owner: str = "") -> None:
    """
    Check that the parts of an agent fit together.

    Raises
    ------
    ValueError
        If a controller lacks a part that it needs, or has one that it does not use; `where` precedes the
        name of the part, `owner` that of the reference.

    """
    kind = agent.controller.kind
    follows = controller_class(kind).follows
    _check_fleet(agent, where)
    parts = PARTS.get(follows, ()) if agent.fleet is None else ()
    for name in ("flocking", "separation", "consensus", "course"):
        section, is_needed = getattr(agent, name), name in parts
        if is_needed and section is None:
            needs = (
                "follows a course" if follows == "course" else "follows a velocity that a flocking law gives"
            )
            raise ValueError(
                f"{where}{name}: missing; allowed: a section, since the controller {kind} {needs}"
            )
        if section is not None and not is_needed:
            itself = "" if follows in PARTS else " by itself"
            raise ValueError(
                f"{where}{name}: {section.kind!r} is not allowed; allowed: nothing, since the controller "
                f"{kind} follows a {follows}{itself}"
            )
    if reference is None and follows in FOLLOW_REFERENCE:
        raise ValueError(
            f"{owner}reference: missing; allowed: a section, since the controller {kind} follows a {follows}"
        )
    if reference is not None and follows == "course":
        raise ValueError(
            f"{owner}reference: {reference.kind!r} is not allowed; allowed: nothing, "
            f"since the controller {kind} follows {where}course"
        )


def _check_fleet(agent: AgentSettings, where: str) -> None:
    """Check that a fleet has autopilots, and that no vehicle has a course of its own beside it."""
    follows = controller_class(agent.controller.kind).follows
    if agent.fleet is not None and follows != "course":
        raise ValueError(
            f"{where}fleet: {agent.fleet.kind!r} is not allowed; allowed: nothing, since the controller "
            f"{agent.controller.kind} follows a {follows}"
        )
    if agent.fleet is not None and agent.course is not None:
        raise ValueError(
            f"{where}course: {agent.course.kind!r} is not allowed; allowed: nothing beside a fleet"
        )


def report_format(agent: AgentSettings, fleet_size: int) -> ReportFormat:
    """Return the format of an agent's reports, with what the consensus filter or the task of a fleet adds."""
    return SpokenReport.of(agent).format(fleet_size)


def report_decoder(config: AgentConfig) -> ReportDecoder:
    """Return what reads the reports of all vehicles that an agent may hear."""
    own = report_format(config, config.fleet_size)
    if not config.heard_reports:
        return own
    others = {spoken.report.kind: spoken.format(config.fleet_size) for spoken in config.heard_reports}
    return ReportReader({**others, config.report.kind: own})
