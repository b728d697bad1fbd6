"""
The agent: one vehicle's computer.  No clock, no ROS, no randomness; the same object runs in a node and in
one process.

Once per control period: read the packets, carry the neighbours to now, ask the flocking law for a velocity,
the controller for a command, hand a report to the modem when it asks for one, and advance the consensus on
the flocking centre.
"""

from __future__ import annotations

from dataclasses import dataclass

from auv_control.controllers import VelocityReference
from auv_core.geometry import Vec3, body_to_ned
from auv_core.messages import Command, Inbox, Packet, VehicleState
from auv_core.params import Section, param
from auv_core.plugins import find_plugin
from auv_flocking.flocking import PathPoint, View
from auv_flocking.neighbours import NeighbourConfig, NeighbourEstimate, NeighbourTable, is_plausible
from auv_flocking.report import Report, ReportError, decode, encode

REFERENCES = "auv_control.references"
CONTROLLERS = "auv_control.controllers"
FLOCKING = "auv_flocking.flocking"
SEPARATION = "auv_flocking.separation"
CONSENSUS = "auv_flocking.consensus"

Obstacles = tuple[tuple[Vec3, float], ...]


@dataclass(frozen=True, kw_only=True)
class AgentConfig:
    """Everything that one agent needs to know."""

    vehicle_id: str = param("name of the vehicle, also its namespace")
    address: int = param("acoustic address of this vehicle, from 1", minimum=1, maximum=254)
    fleet_size: int = param("number of vehicles", minimum=1, maximum=254)
    is_leader: bool = param("whether this vehicle knows the path", default=False)
    period_s: float = param("control period (s)", default=0.1, above=0.0)
    hold_s: float = param(
        "hold station at most so long until every neighbour was heard (s)", default=0.0, minimum=0.0
    )
    obstacles_ned_m: tuple[float, ...] = param("obstacle positions, three numbers each (m; NED)", default=())
    obstacle_safety_distances_m: tuple[float, ...] = param(
        "safety distance of each obstacle (m)", default=(), above=0.0
    )
    reference: Section = param("path to follow", plugins=REFERENCES)
    flocking: Section = param("flocking law", plugins=FLOCKING)
    separation: Section = param("separation law", plugins=SEPARATION)
    consensus: Section = param("consensus filter of the flocking centre", plugins=CONSENSUS)
    neighbours: NeighbourConfig = param("neighbour filters", default=NeighbourConfig())
    controller: Section = param("from velocity to command", plugins=CONTROLLERS)

    def __post_init__(self) -> None:
        if len(self.obstacles_ned_m) != 3 * len(self.obstacle_safety_distances_m):
            raise ValueError(
                f"obstacles_ned_m: {len(self.obstacles_ned_m)} numbers are not allowed; "
                "allowed: three for each of the "
                f"{len(self.obstacle_safety_distances_m)} safety distances"
            )

    @property
    def obstacles(self) -> Obstacles:
        """Obstacle positions (m; NED) with their safety distances (m)."""
        x = self.obstacles_ned_m
        return tuple(
            ((x[3 * i], x[3 * i + 1], x[3 * i + 2]), safety_distance_m)
            for i, safety_distance_m in enumerate(self.obstacle_safety_distances_m)
        )


class Agent:
    """
    One vehicle's computer.

    After a step, for people to look at: `centre` and `centre_rate` (own estimate of the flocking centre, m
    and m/s; NED), `flock_velocity` (m/s; NED), `reference` (what the law asked) and `neighbours` (the
    estimates that the step used).
    """

    def __init__(self, config: AgentConfig) -> None:
        self._config = config
        self._obstacles = config.obstacles
        self._path = find_plugin(REFERENCES, config.reference.kind).Reference(config.reference.params)
        separation = find_plugin(SEPARATION, config.separation.kind).Separation(config.separation.params)
        flocking = find_plugin(FLOCKING, config.flocking.kind)
        self._law = flocking.Flocking(config.flocking.params, separation, config.is_leader)
        self._consensus = find_plugin(CONSENSUS, config.consensus.kind).Consensus(config.consensus.params)
        controller = find_plugin(CONTROLLERS, config.controller.kind)
        self._controller = controller.Controller(config.controller.params, config.period_s)
        self._table = NeighbourTable(config.neighbours)
        self._sequence = 0
        self._next_centre: Vec3 | None = None
        self.rejected = 0
        self.centre: Vec3 = (0.0, 0.0, 0.0)
        self.centre_rate: Vec3 = (0.0, 0.0, 0.0)
        self.flock_velocity: Vec3 = (0.0, 0.0, 0.0)
        self.reference = VelocityReference((0.0, 0.0, 0.0), self._path.heading_rad)
        self.neighbours: list[NeighbourEstimate] = []

    @property
    def takes_velocity(self) -> bool:
        """Whether the commands of this agent are velocities instead of wrenches."""
        return bool(self._controller.command == "velocity")

    @property
    def outdated(self) -> int:
        """Number of packets that came after a newer one of the same sender."""
        return self._table.outdated

    @property
    def path_period_s(self) -> float | None:
        """Time of one round of the path (s), or None."""
        period_s: float | None = self._path.period_s
        return period_s

    def step(self, t_s: float, nav: VehicleState, inbox: Inbox) -> tuple[Command, list[Packet]]:
        """
        Return the command for one control period and the packets to hand to the modem.

        Parameters
        ----------
        t_s : float
            Scenario time of the tick (s).
        nav : VehicleState
            The vehicle's own navigation at the tick.
        inbox : Inbox
            What the modem received since the last tick.

        """
        self._receive(inbox, t_s)
        self.neighbours = self._table.estimates(t_s)
        self.centre = nav.position if self._next_centre is None else self._next_centre
        centres = [neighbour.centre for neighbour in self.neighbours]
        heard = [self.flock_velocity, *(neighbour.flock_velocity for neighbour in self.neighbours)]
        path = self.path_point(t_s)
        self.flock_velocity = self._law.flock_velocity(path, self.centre, heard)
        velocity = self.velocity(path, nav.position, self.centre, tuple(n.position for n in self.neighbours))
        if self._table.heard < self._config.fleet_size - 1 and t_s < self._config.hold_s:
            velocity = (0.0, 0.0, 0.0)
        self.reference = VelocityReference(velocity, self._path.heading_rad)
        command: Command = self._controller.step(nav, self.reference)
        self.centre_rate = self.consensus_rate(nav.position, self.centre, centres)
        self._next_centre = self._consensus.step(
            nav.position, self.centre, centres, self.flock_velocity, self._config.period_s
        )
        return command, [self._packet(inbox.tick, t_s, nav)] if inbox.transmit_ready else []

    def path_point(self, t_s: float) -> PathPoint:
        """Return the reference at `t_s`."""
        return PathPoint(self._path.position(t_s), self._path.velocity(t_s))

    def velocity(self, path: PathPoint, position: Vec3, centre: Vec3, neighbours: tuple[Vec3, ...]) -> Vec3:
        """
        Return what the flocking law asks (m/s; NED) of this vehicle at `position`, with its present flock
        velocity.
        """
        view = View(position, centre, self.flock_velocity, neighbours, self._obstacles, path)
        velocity: Vec3 = self._law.velocity(view)
        return velocity

    def consensus_rate(self, position: Vec3, centre: Vec3, neighbour_centres: list[Vec3]) -> Vec3:
        """Return the rate of the flocking-centre estimate (m/s; NED)."""
        rate: Vec3 = self._consensus.derivative(position, centre, neighbour_centres, self.flock_velocity)
        return rate

    def _receive(self, inbox: Inbox, t_s: float) -> None:
        for reception in inbox.receptions:
            try:
                report = decode(reception.packet.payload)
            except ReportError:
                self.rejected += 1
                continue
            if is_plausible(report, self._config.address, self._config.fleet_size, t_s):
                self._table.receive(report)
            else:
                self.rejected += 1

    def _packet(self, tick: int, t_s: float, nav: VehicleState) -> Packet:
        self._sequence += 1
        velocity = body_to_ned(nav.attitude, (nav.nu[0], nav.nu[1], nav.nu[2]))
        report = Report(
            self._config.address,
            self._sequence,
            t_s,
            nav.position,
            velocity,
            self.centre,
            self.centre_rate,
            self.flock_velocity,
        )
        return Packet(tick, self._config.address, 0, self._sequence, encode(report))
