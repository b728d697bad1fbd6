"""
The agent: the software of one vehicle. It has no clock, no ROS and no randomness; the same object runs in a
node and in an in-process run.

Once per control period it reads the packets, extrapolates the neighbour estimates to the current time, does
the task (a flocking law with a velocity controller and consensus on the centre, a law that gives the wrench
directly, or autopilots under a course), and passes a report to the modem when the modem asks for one.
"""

from __future__ import annotations

import math

from auv_control.controllers import (
    Controller,
    CourseController,
    MotionLaw,
    VelocityReference,
    make_controller,
)
from auv_control.courses import make_course
from auv_control.references import PathPoint, make_reference
from auv_control.thruster_computer import ThrusterComputer
from auv_core.geometry import Vec3, body_to_ned, heading_from_quaternion
from auv_core.messages import Command, Inbox, Packet, VehicleState, VelocityCommand, Wrench, command_numbers
from auv_core.state_checks import is_command
from auv_flocking.agent_config import AgentConfig, report_format
from auv_flocking.consensus import ConsensusFilter, make_consensus
from auv_flocking.course_task import CourseTask
from auv_flocking.fleets import FleetTask, make_fleet
from auv_flocking.flock_task import FlockTask
from auv_flocking.flocking import FlockVelocity, make_flocking
from auv_flocking.group import Group, as_obstacles
from auv_flocking.heard import class_of_all, mask_of
from auv_flocking.holding import FAILED, NO_FINITE_COMMAND, OUT_OF_REPORT
from auv_flocking.motion_task import MotionTask
from auv_flocking.neighbours.estimates import Estimates
from auv_flocking.packet_judge import Refusal
from auv_flocking.pings import NO_PING
from auv_flocking.report import Report, ReportError, why_not_carried
from auv_flocking.senses import senses_of
from auv_flocking.separation import make_separation
from auv_flocking.trackers import Sensed


class Agent:
    """
    The software of one vehicle; `flocks` tells whether it is part of a flock and estimates the flock's
    centre, `command` the kind of its commands.

    After a step it offers for inspection: `centre` and `centre_rate` (own estimate of the flocking centre, m
    and m/s; NED), `flock_velocity` (m/s; NED, with its stamp), `reference` (the law's velocity, or the
    path's), `law_state` (the state of the law), `neighbours` and `sensed` (the estimates of vehicles and
    obstacles that the step used) and `holding` (why it gave the safe command instead of the law's, or an
    empty text).
    """

    def __init__(self, config: AgentConfig) -> None:
        self._config = config
        self._path = None if config.reference is None else make_reference(config.reference)
        self._group = Group(config.group, config.address, config.fleet_size)
        consensus = None if config.consensus is None else make_consensus(config.consensus, self._group.size)
        self._format = report_format(config, config.fleet_size)
        controller = make_controller(config.controller, config.period_s)
        self._thrusters = (
            ThrusterComputer(config.allocation, config.thrusters, config.fault, config.period_s)
            if config.thrusters.count
            else None
        )
        self.command = controller.command if self._thrusters is None else "thrusters"
        self.task = self._make_task(controller, consensus)
        self._fleet = self.task if isinstance(self.task, FleetTask) else None
        self.flocks = isinstance(self.task, FlockTask)
        self._vouched_s = self.task.vouched_s if isinstance(self.task, FlockTask) else math.inf
        self._senses = senses_of(config)
        self._fails_at_s = math.inf if config.fails_at_s is None else config.fails_at_s
        self._sequence = 0
        self._is_waiting = False
        self.unsent = 0
        self.holding = ""
        self.neighbours = Estimates.of(())
        self.sensed: Sensed = ()
        self._ping = NO_PING

    def _make_task(
        self, controller: Controller, consensus: ConsensusFilter | None
    ) -> FlockTask | MotionTask | CourseTask | FleetTask:
        config = self._config
        member = self._group.member(is_leader=config.is_leader)
        if isinstance(controller, CourseController):
            if config.fleet is not None:
                return make_fleet(config.fleet, member, controller, config.period_s, config.mission)
            if config.course is None:
                raise RuntimeError("autopilots without a course: AgentConfig should have refused it")
            return CourseTask(make_course(config.course, config.period_s), controller)
        if isinstance(controller, MotionLaw):
            return MotionTask(controller, config.obstacles, config.period_s)
        if config.flocking is None or config.separation is None or consensus is None:
            raise RuntimeError("a flock without its laws: AgentConfig should have refused it")
        separation = make_separation(config.separation)
        law = make_flocking(config.flocking, separation, member)
        return FlockTask(
            law, consensus, controller, config.obstacles, config.period_s, is_leader=config.is_leader
        )

    @property
    def knows_path(self) -> bool:
        """Whether this agent follows a path itself, or leads a flock along one."""
        return self._path is not None and (self._config.is_leader or not self.flocks)

    @property
    def centre(self) -> Vec3:
        """Own estimate of the flocking centre (m; NED)."""
        return self.task.centre

    @property
    def centre_rate(self) -> Vec3:
        """Rate of that estimate (m/s; NED)."""
        return self.task.centre_rate

    @property
    def flock_velocity(self) -> FlockVelocity:
        """Estimate of the flock's velocity (m/s; NED), with its stamp."""
        return self.task.flock_velocity

    @property
    def reference(self) -> VelocityReference:
        """Velocity and heading of the flocking law, or of the path."""
        return self.task.reference

    @property
    def law_state(self) -> tuple[float, ...]:
        """The law's state at the step, `()` for a law without state."""
        return self.task.law_state

    @property
    def rejected(self) -> int:
        """Number of packets that were refused."""
        return self._senses.packets.rejected

    @property
    def refusals(self) -> dict[int, Refusal]:
        """Why the newest packet of a sender was refused, by address; empty if all packets are accepted."""
        return self._senses.packets.refusals

    @property
    def contacts_refused(self) -> int:
        """Number of implausible sonar contacts."""
        return self._senses.table.contacts_refused

    @property
    def outdated(self) -> int:
        """Number of packets that arrived after a newer one of the same sender."""
        return self._senses.table.outdated

    @property
    def saturated(self) -> int:
        """Number of values that exceeded their field of a report and were sent as its bound."""
        return self._format.saturated

    @property
    def path_period_s(self) -> float | None:
        """Time of one round of the path (s), or None."""
        return None if self._path is None else self._path.period_s

    def step(self, t_s: float, nav: VehicleState | None, inbox: Inbox) -> tuple[Command, list[Packet]]:
        """
        Return the command for one control period and the packets for the modem.

        The command is the safe one (no force, no velocity, or a circle) if the navigation is missing, old,
        marked as invalid or impossible; in a fleet, also if the modem is silent or no report can carry the
        position; and if the law gives no finite command. Then `holding` says why, and the law's state does
        not change. In all of these cases but the last nothing is sent. A computer that has failed, as its
        configuration has it, does the same from then on.

        Parameters
        ----------
        t_s : float
            Scenario time of the tick (s).
        nav : VehicleState, optional
            Newest output of the vehicle's own navigation, if any; its tick gives its age.
        inbox : Inbox
            Data from the modem since the last tick; its tick gives its age.

        """
        if self._fails_at_s <= t_s:
            self.holding = FAILED
            return self._safe_command(), []
        packets = [each.packet for each in inbox.receptions]
        found = self._senses.take(t_s, nav, packets, inbox.contacts)
        usable, self.holding = found.nav, found.why_no_nav
        self.neighbours, self.sensed, self._ping = found.neighbours, found.obstacles, found.ping
        if usable is not None and self._config.fleet_size > 1:
            self.holding = self._senses.inputs.modem(t_s, inbox.tick) or self._uncarried(usable.position)
        if usable is None or self.holding:
            return self._safe_command(), []
        command = self._act_safely(t_s, usable)
        sends = inbox.transmit_ready and (self._fleet is None or self._fleet.sends(t_s))
        return command, self._packets(inbox.tick, t_s, usable) if sends else []

    def _uncarried(self, position: Vec3) -> str:
        words = why_not_carried(position, self._format.carries.position)
        return f"{OUT_OF_REPORT}: {words}" if words else ""

    def _act_safely(self, t_s: float, nav: VehicleState) -> Command:
        try:
            command = self._act(t_s, nav)
        except ArithmeticError:
            self.holding = NO_FINITE_COMMAND
            return self._safe_command()
        if is_command(command_numbers(command)):
            return self._allocated(t_s, command)
        self.holding = NO_FINITE_COMMAND
        return self._safe_command()

    def _act(self, t_s: float, nav: VehicleState) -> Command:
        heard, others = self._senses.table.heard, self._config.fleet_size - 1
        self._is_waiting = is_waiting = t_s < self._config.hold_s and heard < others
        path = self.path_point(t_s)
        if isinstance(self.task, CourseTask):
            return self.task.step(t_s, nav)
        if isinstance(self.task, MotionTask):
            return self.task.step(t_s, nav, path, self.neighbours, self.sensed, is_waiting=is_waiting)
        mates, strangers = self._group.split(self.neighbours)
        if self._fleet is not None:
            return self._fleet.step(t_s, nav, mates, strangers)
        if path is None or not isinstance(self.task, FlockTask):
            raise RuntimeError("a flock without a path: AgentConfig should have refused it")
        sensed = self.sensed
        if strangers:
            sensed += as_obstacles(strangers, self._config.clearance_m)
        command = self.task.step(t_s, nav, path, mates, sensed, self._ping, is_waiting=is_waiting)
        self._is_waiting = self.task.is_staying
        return command

    def _allocated(self, t_s: float, command: Command) -> Command:
        """Return the command itself, or the forces of thrusters for its wrench."""
        if self._thrusters is None or not isinstance(command, Wrench):
            return command
        return self._thrusters.command(t_s, command.tau)

    def _safe_command(self) -> Command:
        if isinstance(self.task, CourseTask):
            return self.task.safe_command
        if self._fleet is not None:
            return self._fleet.safe_command
        if self._thrusters is not None:
            return self._thrusters.rest()
        if self.command == "velocity":
            return VelocityCommand((0.0, 0.0, 0.0), 0.0)
        return Wrench((0.0, 0.0, 0.0, 0.0, 0.0, 0.0))

    def path_point(self, t_s: float) -> PathPoint | None:
        """Return the reference at `t_s`, or None if there is no path."""
        return None if self._path is None else self._path.at(t_s)

    def _packets(self, tick: int, t_s: float, nav: VehicleState) -> list[Packet]:
        """Return the packet that the modem asks for, or none if its numbers cannot be sent."""
        velocity = body_to_ned(nav.attitude, (nav.nu[0], nav.nu[1], nav.nu[2]))
        ages_s = {track.report.address: t_s - track.report.time_s for track in self._senses.table.tracks}
        code = class_of_all(ages_s, self._vouched_s)
        report = Report(
            self._config.address,
            t_s,
            nav.position,
            velocity,
            self.centre,
            self.flock_velocity.velocity,
            self.flock_velocity.stamp_s,
            self.flock_velocity.turn_rate_radps,
            heading_from_quaternion(nav.attitude),
            nav.position_sd_m,
            nav.is_bounded,
            self._is_waiting or bool(self.holding),
            code,
            mask_of(ages_s, self._config.address, self._config.fleet_size, code),
            self.task.shared(),
        )
        try:
            payload = self._format.encode(report)
        except ReportError:
            self.unsent += 1
            return []
        self._sequence += 1
        return [Packet(tick, self._config.address, 0, self._sequence, payload)]
