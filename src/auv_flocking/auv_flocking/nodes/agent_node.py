"""
ROS node of one agent: takes its navigation and its modem's inbox, publishes a command and what it hands to
the modem.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, TwistStamped, WrenchStamped
from nav_msgs.msg import Path
from rclpy.node import Node
from rclpy.qos import QoSProfile
from visualization_msgs.msg import MarkerArray

from auv_core.alarm import Alarm
from auv_core.geometry import Vec3
from auv_core.messages import Inbox, command_numbers
from auv_core.messages import VehicleState as State
from auv_flocking.agent import Agent
from auv_flocking.agent_config import AgentConfig
from auv_flocking.holding import cause_number
from auv_flocking.mail import Mail
from auv_flocking.neighbours.estimates import CENTRE
from auv_flocking.nodes.agent_diagnostics import agent_statuses
from auv_msgs.msg import (
    AcousticInbox,
    AcousticOutbox,
    ControlStatus,
    FlockingCentre,
    NeighbourEstimates,
    VehicleState,
)
from auv_ros.hearing import Hearing
from auv_ros.lifecycle import (
    WAITS_FOR_RUN,
    Audience,
    Rendezvous,
    main_loop,
    publishes_bytes,
    tick_clock,
    when_running,
)
from auv_ros.parameters import declare_config
from auv_ros.qos import EVERY_TICK, LATCHED, own_qos
from auv_ros.run_config import AGENT_PHASE, RunConfig
from auv_ros.run_watch import Standstill
from auv_ros.steady_timer import SteadyTimer
from auv_ros.wire import conversions as convert
from auv_ros.wire.acoustics import outbox_bytes, read_inbox
from auv_ros.wire.diagnostics import Status, diagnostics_bytes
from auv_ros.wire.markers import MARKER_TICKS, STANDING_MARKER_TICKS, lines, sphere, sphere_stencil

_DIAGNOSTIC_TICKS = 10
_NOT_THIS_TICK = "not of this tick of lock-step"
_PATH_POINTS = 120
_PATH_SPAN_S = 600.0


class AgentNode(Node):
    """One `Agent` behind topics."""

    def __init__(self, **options: Any) -> None:
        super().__init__("agent_node", **options)
        run = declare_config(self, RunConfig)
        self._config = declare_config(self, AgentConfig)
        self._ticks = tick_clock(run, self._config.period_s)
        self._agent = Agent(self._config)
        self._mail = Mail(self._config.inputs, self._config.period_s)
        self._alarm = Alarm(self.get_logger(), "holds, safe command", "acts again")
        self._nav: State | None = None
        self._inbox: Inbox | None = None
        self._tick = 0
        self._timer: SteadyTimer | None = None
        self._standstill = Standstill(self._tick)
        self._connect(own_qos(admits_strangers=run.admits_strangers))
        self._meeting = Rendezvous(self, self._audiences(run), self._start)

    def _connect(self, heard: QoSProfile) -> None:
        command = (TwistStamped, "cmd_vel") if self._agent.takes_velocity else (WrenchStamped, "cmd_wrench")
        vehicle_id = self._config.vehicle_id
        self._command_stencil = convert.command_stencil(vehicle_id, takes_velocity=self._agent.takes_velocity)
        self._centre_marker = sphere_stencil(f"{vehicle_id} centre", 0, 0.15, (0.9, 0.2, 0.6, 1.0))
        self._reference_stencil = convert.velocity_stencil()
        self._centre_stencil = convert.centre_stencil()
        self._known: list[int] = []
        self._neighbours_stencil = convert.neighbours_stencil(self._known)
        self._body_frame = convert.body_frame(vehicle_id)
        self._command_pub = self.create_publisher(*command, EVERY_TICK)
        self._outbox_pub = self.create_publisher(AcousticOutbox, "acoustic/tx", EVERY_TICK)
        self._reference_pub = self.create_publisher(TwistStamped, "reference", EVERY_TICK)
        self._centre_pub = self.create_publisher(FlockingCentre, "flocking_centre", EVERY_TICK)
        self._control_pub = self.create_publisher(ControlStatus, "control_status", EVERY_TICK)
        self._neighbours_pub = self.create_publisher(NeighbourEstimates, "neighbours", EVERY_TICK)
        self._publish_command, self._publish_outbox, self._publish_reference = map(
            publishes_bytes, (self._command_pub, self._outbox_pub, self._reference_pub)
        )
        self._marker_pub = self.create_publisher(MarkerArray, "/markers", EVERY_TICK)
        self._publish_centre, self._publish_neighbours, self._publish_marker = map(
            publishes_bytes, (self._centre_pub, self._neighbours_pub, self._marker_pub)
        )
        self._diagnostics_pub = self.create_publisher(DiagnosticArray, "/diagnostics", EVERY_TICK)
        self._publish_diagnostics = publishes_bytes(self._diagnostics_pub)
        self._path_pub = self.create_publisher(Path, "path", LATCHED) if self._agent.knows_path else None
        self._hearing = Hearing(self)
        self._hearing.listen(VehicleState, "nav", self._on_nav, heard)
        self._hearing.listen(AcousticInbox, "acoustic/rx", self._on_inbox, heard)

    def _audiences(self, run: RunConfig) -> list[Audience]:
        recorder = {"/recorder_node"} if run.recorded else set()
        vehicle = f"{self.get_namespace().rstrip('/')}/vehicle_node"
        listeners: dict[Any, set[str]] = {
            self._command_pub: {vehicle},
            self._outbox_pub: {"/acoustic_relay_node"},
            self._reference_pub: set(),
            self._centre_pub: set(),
            self._control_pub: set(),
            self._neighbours_pub: set(),
            self._marker_pub: set(),
            self._diagnostics_pub: set(),
        }
        if not run.waits:
            listeners = {publisher: set() for publisher in listeners}
        return [Audience(publisher, frozenset(names | recorder)) for publisher, names in listeners.items()]

    def _start(self) -> None:
        if self._ticks.lockstep:
            self._publish_path()
            self._step_if_ready()
        else:
            when_running(self, self._ticks, self._begin)

    def _begin(self) -> None:
        self._publish_path()
        self._mail.start(max(self._ticks.tick_now(), 0))
        first_in_s = self._ticks.until_phase_s(AGENT_PHASE)
        self._timer = SteadyTimer(self, self._config.period_s, self._run_free, first_in_s)

    def on_run_end(self) -> None:
        """Give no more commands."""
        if self._timer is not None:
            self._timer.cancel()

    def waits_for(self) -> str:
        """Return for what the node waits, in words, or nothing."""
        if not self._meeting.ready:
            return self._meeting.waits_for()
        if not self._ticks.started:
            return WAITS_FOR_RUN
        if not self._ticks.lockstep or not self._standstill.at(self._tick):
            return ""
        owed = [topic for topic, it in (("nav", self._nav), ("acoustic/rx", self._inbox)) if it is None]
        return f"{' and '.join(owed)} of tick {self._tick}"

    def _on_nav(self, data: bytes) -> None:
        nav = convert.state_from_bytes(data)
        if not self._ticks.lockstep:
            self._mail.navs.hear(nav, nav.tick, self._now_tick(nav.tick))
        elif nav.tick == self._tick:
            self._nav = nav
            self._step_if_ready()
        else:
            self._mail.navs.drop(nav.tick, self._tick, _NOT_THIS_TICK)

    def _on_inbox(self, data: bytes) -> None:
        inbox = read_inbox(data, self._ticks.epoch_ns)
        if not self._ticks.lockstep:
            self._mail.hear_inbox(inbox, self._now_tick(inbox.tick))
        elif inbox.tick == self._tick:
            self._inbox = inbox
            self._step_if_ready()
        else:
            self._mail.inboxes.drop(inbox.tick, self._tick, _NOT_THIS_TICK)

    def _now_tick(self, tick: int) -> int:
        """Return the tick that it is now in real time, or that of an input as long as it is not known."""
        return self._ticks.tick_now() if self._ticks.started else tick

    def _step_if_ready(self) -> None:
        nav, inbox, tick = self._nav, self._inbox, self._tick
        if self._meeting.ready and nav is not None and inbox is not None:
            self._nav = self._inbox = None
            self._tick += 1
            self._step(tick, nav, inbox)

    def _run_free(self) -> None:
        tick = self._ticks.tick_now()
        if tick < max(self._tick, 0) or self._mail.awaits_first(tick):
            return
        self._tick = tick + 1
        self._step(tick, self._mail.nav, self._mail.take_inbox())

    def _step(self, tick: int, nav: State | None, inbox: Inbox) -> None:
        scenario_s = self._ticks.scenario_s(tick)
        command, packets = self._agent.step(scenario_s, nav, inbox)
        t_s = self._ticks.stamp_s(tick)
        self._publish_command(self._command_stencil.filled(t_s, *command_numbers(command)))
        self._publish_outbox(outbox_bytes(self._body_frame, tick, packets, t_s))
        self._publish_beliefs(tick, t_s)
        if tick % MARKER_TICKS == 0:
            self._publish_markers(tick, t_s)
        holding = self._agent.holding
        if self._alarm.note(cause_number(holding), holding, scenario_s) or tick % _DIAGNOSTIC_TICKS == 0:
            self._publish_diagnostics(diagnostics_bytes(self._statuses(scenario_s), t_s))

    def _statuses(self, scenario_s: float) -> list[Status]:
        malformed = self._hearing.malformed.total()
        return agent_statuses(self._agent, self._config, self._mail, malformed, scenario_s)

    def _publish_beliefs(self, tick: int, t_s: float) -> None:
        agent = self._agent
        self._publish_reference(self._reference_stencil.filled(t_s, *agent.reference.velocity, 0.0, 0.0, 0.0))
        if agent.flocks:
            self._publish_centre(self._centre_stencil.filled(t_s, tick, *agent.centre, *agent.centre_rate))
        if agent.law_state or agent.holding:
            self._control_pub.publish(self._control_status(tick, t_s))
        neighbours = agent.neighbours
        if neighbours.addresses != self._known:
            self._known = neighbours.addresses
            self._neighbours_stencil = convert.neighbours_stencil(self._known)
        self._publish_neighbours(self._neighbours_stencil.filled(t_s, tick, neighbours.rows[:, :CENTRE]))

    def _control_status(self, tick: int, t_s: float) -> ControlStatus | bytes:
        vehicle_id, holding, memory = self._config.vehicle_id, self._agent.holding, self._agent.law_state
        if holding:
            return convert.control_status(tick, t_s, vehicle_id, holding, memory)
        return convert.control_stencil(vehicle_id, len(memory)).filled(t_s, tick, 1, 0, len(memory), *memory)

    def _publish_markers(self, tick: int, t_s: float) -> None:
        if self._agent.flocks:
            self._publish_marker(self._centre_marker.filled(t_s, *self._agent.centre))
        if tick % STANDING_MARKER_TICKS == 0 and self._standing_markers:
            for marker in self._standing_markers:
                marker.header.stamp = convert.stamp(t_s)
            self._marker_pub.publish(MarkerArray(markers=self._standing_markers))

    @cached_property
    def _standing_markers(self) -> list[Any]:
        name = self._config.vehicle_id
        markers = []
        if self._agent.knows_path:
            markers.append(
                lines(f"{name} path", 0, 0.0, self._path_points, (0.3, 0.9, 0.3, 1.0), joined=True)
            )
        if self._config.address == 1:
            for number, (obstacle, safety_distance_m) in enumerate(self._config.obstacles):
                colour = (0.9, 0.3, 0.2, 0.25)
                markers.append(sphere("obstacles", number, 0.0, obstacle, 2.0 * safety_distance_m, colour))
        return markers

    @cached_property
    def _path_points(self) -> list[Vec3]:
        span_s = self._agent.path_period_s or _PATH_SPAN_S
        points = [self._agent.path_point(k * span_s / _PATH_POINTS) for k in range(_PATH_POINTS + 1)]
        return [point.position for point in points if point is not None]

    def _publish_path(self) -> None:
        if self._path_pub is not None:
            self._path_pub.publish(self._path())

    def _path(self) -> Path:
        header = convert.header(self._ticks.stamp_s(0), convert.WORLD_FRAME)
        poses = []
        for place in self._path_points:
            pose = PoseStamped(header=header)
            pose.pose.position = convert.point(place)
            poses.append(pose)
        return Path(header=header, poses=poses)


def make_nodes(**options: Any) -> Sequence[Node]:
    """Return the node; `options` are those of `rclpy.node.Node`."""
    return [AgentNode(**options)]


def main() -> None:
    """Run the node."""
    raise SystemExit(main_loop(make_nodes))


if __name__ == "__main__":
    main()
