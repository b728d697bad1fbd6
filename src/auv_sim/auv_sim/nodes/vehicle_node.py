"""
ROS node of one simulated vehicle: takes a command, publishes the true state, its navigation, and what people
and tools see of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import TwistStamped, WrenchStamped
from rclpy.node import Node

from auv_core.alarm import Alarm
from auv_core.cdr import MalformedError
from auv_core.messages import Command
from auv_msgs.msg import VehicleState
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
from auv_ros.qos import EVERY_TICK, own_qos
from auv_ros.run_config import VEHICLE_PHASE, RunConfig
from auv_ros.run_watch import Standstill
from auv_ros.steady_timer import SteadyTimer
from auv_ros.wire import conversions as convert
from auv_ros.wire.diagnostics import Status, diagnostics_bytes
from auv_ros.wire.stencil import header_stamp_s
from auv_sim.command_watch import CommandWatch
from auv_sim.nodes.vehicle_view import VehicleView
from auv_sim.vehicle import DivergedError, Vehicle, VehicleConfig

_CATCH_UP_TICKS = 20
_DIAGNOSTIC_TICKS = 20


class VehicleNode(Node):
    """One `Vehicle` behind topics."""

    def __init__(self, **options: Any) -> None:
        super().__init__("vehicle_node", **options)
        run = declare_config(self, RunConfig)
        self._config = declare_config(self, VehicleConfig)
        self._clock_ticks = tick_clock(run, self._config.period_s)
        self._vehicle = Vehicle(self._config)
        self._has_begun = False
        self._watch = CommandWatch(self._config.command_max_age_s, self._config.period_s)
        self._alarm = Alarm(self.get_logger(), "the actuators rest", "the actuators act again")
        self._timer: SteadyTimer | None = None
        self._standstill = Standstill(self._vehicle.state.tick)
        self.exit_code, self.done = 0, False
        self._state_pub = self.create_publisher(VehicleState, "state", EVERY_TICK)
        self._nav_pub = self.create_publisher(VehicleState, "nav", EVERY_TICK)
        self._publish_state, self._publish_nav = map(publishes_bytes, (self._state_pub, self._nav_pub))
        self._diagnostics_pub = self.create_publisher(DiagnosticArray, "/diagnostics", EVERY_TICK)
        self._publish_diagnostics = publishes_bytes(self._diagnostics_pub)
        self._view = VehicleView(self, self._config, self._vehicle.navigation.velocity_sd_mps)
        command = (TwistStamped, "cmd_vel") if self._vehicle.takes_velocity else (WrenchStamped, "cmd_wrench")
        heard = own_qos(admits_strangers=run.admits_strangers)
        self._hearing = Hearing(self)
        self._hearing.listen(*command, self._on_command, heard)
        self._state_stencil = convert.state_stencil()
        self._meeting = Rendezvous(self, self._audiences(run), self._start)

    def _audiences(self, run: RunConfig) -> list[Audience]:
        recorder = {"/recorder_node"} if run.recorded else set()
        agent = f"{self.get_namespace().rstrip('/')}/agent_node"
        listeners = {self._state_pub: {"/acoustic_relay_node"}, self._nav_pub: {agent}}
        if not run.waits:
            listeners = {}
        publishers = (self._state_pub, self._nav_pub, self._diagnostics_pub, *self._view.publishers)
        return [
            Audience(publisher, frozenset(listeners.get(publisher, set()) | recorder))
            for publisher in publishers
        ]

    def _start(self) -> None:
        if self._clock_ticks.lockstep:
            self._publish()
        else:
            when_running(self, self._clock_ticks, self._begin)

    def _begin(self) -> None:
        self._watch.newest.start(max(self._clock_ticks.tick_now(), 0))
        first_in_s = self._clock_ticks.until_phase_s(VEHICLE_PHASE)
        self._timer = SteadyTimer(self, self._config.period_s, self._run_free, first_in_s)

    def on_run_end(self) -> None:
        """Move no more."""
        if self._timer is not None:
            self._timer.cancel()

    def waits_for(self) -> str:
        """Return for what the node waits, in words, or nothing."""
        if not self._meeting.ready:
            return self._meeting.waits_for()
        if not self._clock_ticks.started:
            return WAITS_FOR_RUN
        tick = self._vehicle.state.tick
        is_still = self._clock_ticks.lockstep and self._standstill.at(tick)
        return f"a command for tick {tick}" if is_still else ""

    def _on_command(self, data: bytes) -> None:
        tick = self._clock_ticks.tick_of_stamp(header_stamp_s(data))
        command: Command | None = None
        try:
            command = convert.command_from_bytes(data, takes_velocity=self._vehicle.takes_velocity)
        except MalformedError:
            raise
        except ValueError as error:
            self.get_logger().error(f"{error}; the actuators rest", throttle_duration_sec=1.0)
        if not self._clock_ticks.lockstep:
            now_tick = self._clock_ticks.tick_now() if self._clock_ticks.started else tick
            self._watch.hear(command, tick, now_tick)
            return
        if tick != self._vehicle.state.tick:
            self.get_logger().warning(
                f"a command for tick {tick}, but this is tick {self._vehicle.state.tick}: not used",
                throttle_duration_sec=1.0,
            )
            return
        self._watch.hear(command, tick, tick)
        if self._step(tick):
            self._publish()

    def _run_free(self) -> None:
        now_tick = self._clock_ticks.tick_now()
        behind = now_tick - self._vehicle.state.tick
        if behind < 0 or (behind == 0 and self._has_begun):
            return
        self._has_begun = True
        for _ in range(min(behind, _CATCH_UP_TICKS)):
            if not self._step(now_tick):
                return
        self._publish()

    def _step(self, now_tick: int) -> bool:
        """Advance the vehicle; where its motion has no finite solution, end the node with one line."""
        try:
            self._vehicle.step(self._watch.command(now_tick))
        except DivergedError as error:
            self.get_logger().fatal(str(error))
            self.exit_code, self.done = 1, True
        return not self.done

    def _publish(self) -> None:
        state, nav = self._vehicle.state, self._vehicle.nav
        t_s = self._clock_ticks.stamp_s(state.tick)
        truth = self._state_stencil.filled(t_s, *convert.state_numbers(state))
        believed = truth if nav is state else self._state_stencil.filled(t_s, *convert.state_numbers(nav))
        self._publish_nav(believed)
        self._publish_state(truth)
        self._view.publish(t_s, self._vehicle)
        resting = self._watch.resting
        is_new = self._alarm.note(
            resting.partition(":")[0], resting, self._clock_ticks.scenario_s(state.tick)
        )
        if is_new or state.tick % _DIAGNOSTIC_TICKS == 0:
            self._publish_diagnostics(diagnostics_bytes([self._status()], t_s))

    def _status(self) -> Status:
        watch, name = self._watch, self._config.vehicle_id
        return Status(
            level=DiagnosticStatus.ERROR if watch.resting else DiagnosticStatus.OK,
            name=f"{name}/vehicle_node: command",
            message=f"the actuators rest: {watch.resting}" if watch.resting else "acts",
            hardware_id=name,
            values=[
                ("commands_dropped", str(watch.newest.dropped)),
                ("last_dropped", watch.newest.dropped_words),
                ("messages_malformed", str(self._hearing.malformed.total())),
            ],
        )


def make_nodes(**options: Any) -> Sequence[Node]:
    """Return the node; `options` are those of `rclpy.node.Node`."""
    return [VehicleNode(**options)]


def main() -> None:
    """Run the node."""
    raise SystemExit(main_loop(make_nodes))


if __name__ == "__main__":
    main()
