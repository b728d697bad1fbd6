"""
ROS node of one simulated vehicle: it takes a command, and publishes the true state, the navigation, and
topics for people and tools.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from auv_core.alarm import Alarm
from auv_core.cdr import MalformedError
from auv_core.messages import Command
from auv_msgs.msg import VehicleState
from auv_ros.hearing import Hearing
from auv_ros.lifecycle import main_loop
from auv_ros.pace import Pace, tick_clock
from auv_ros.parameters import declare_config
from auv_ros.qos import own_qos
from auv_ros.run_config import VEHICLE_PHASE, RunConfig
from auv_ros.topic import Topics
from auv_ros.wire import conversions as convert
from auv_ros.wire.commands import command_from_bytes, command_topic
from auv_ros.wire.diagnostics import diagnostics_bytes
from auv_ros.wire.stencil import header_stamp_s
from auv_sim.command_watch import CommandWatch
from auv_sim.nodes.vehicle_diagnostics import command_status
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
        self._ticks = tick_clock(run, self._config.period_s)
        self._vehicle = Vehicle(self._config)
        self._has_begun = False
        self._watch = CommandWatch(self._config.command_max_age_s, self._config.period_s)
        self._alarm = Alarm(self.get_logger(), "the actuators rest", "the actuators act again")
        self.exit_code, self.done = 0, False
        topics = Topics(self, is_recorded=run.recorded, waits=run.waits)
        self._write_state = convert.state_stencil().filled
        agent = f"{self.get_namespace().rstrip('/')}/agent_node"
        self._state = topics.add(VehicleState, "state", heard_by=["/acoustic_relay_node"])
        self._nav = topics.add(VehicleState, "nav", heard_by=[agent])
        self._diagnostics = topics.add(DiagnosticArray, "/diagnostics", diagnostics_bytes)
        self._view = VehicleView(topics, self._config, self._vehicle.navigation.velocity_sd_mps)
        self._hearing = Hearing(self)
        self._hearing.listen(
            *command_topic(self._vehicle.command),
            self._on_command,
            own_qos(admits_strangers=run.admits_strangers),
        )
        self._pace = Pace(
            self, self._ticks, topics, begin=self._begin, act=self._run_free, phase=VEHICLE_PHASE
        )

    def on_run_end(self) -> None:
        """Stop moving the vehicle."""
        self._pace.stop()

    def waits_for(self) -> str:
        """Return as text what the node waits for, or an empty text."""
        tick = self._vehicle.state.tick
        return self._pace.waits_for(tick, f"a command for tick {tick}" if self._ticks.lockstep else "")

    def _begin(self, tick: int) -> None:
        if self._ticks.lockstep:
            self._publish()
        else:
            self._watch.newest.start(tick)

    def _on_command(self, data: bytes) -> None:
        tick = self._ticks.tick_of_stamp(header_stamp_s(data))
        command: Command | None = None
        try:
            command = command_from_bytes(data, self._vehicle.command, self._vehicle.command_size)
        except MalformedError:
            raise
        except ValueError as error:
            self.get_logger().error(f"{error}; the actuators rest", throttle_duration_sec=1.0)
        if not self._ticks.lockstep:
            self._watch.hear(command, tick, self._ticks.tick_now_or(tick))
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

    def _run_free(self, now_tick: int) -> None:
        behind = now_tick - self._vehicle.state.tick
        if behind < 0 or (behind == 0 and self._has_begun):
            return
        self._has_begun = True
        for _ in range(min(behind, _CATCH_UP_TICKS)):
            if not self._step(now_tick):
                return
        self._publish()

    def _step(self, now_tick: int) -> bool:
        """Advance the vehicle; if its motion has no finite solution, end the node with one line."""
        try:
            self._vehicle.step(self._watch.command(now_tick))
        except DivergedError as error:
            self.get_logger().fatal(str(error))
            self.exit_code, self.done = 1, True
        return not self.done

    def _publish(self) -> None:
        state, nav = self._vehicle.state, self._vehicle.nav
        t_s = self._ticks.stamp_s(state.tick)
        truth = self._write_state(t_s, *convert.state_numbers(state))
        believed = truth if nav is state else self._write_state(t_s, *convert.state_numbers(nav))
        self._nav.publish_bytes(believed)
        self._state.publish_bytes(truth)
        self._view.publish(t_s, self._vehicle)
        resting = self._watch.resting
        is_new = self._alarm.note(resting.partition(":")[0], resting, self._ticks.scenario_s(state.tick))
        if is_new or state.tick % _DIAGNOSTIC_TICKS == 0:
            malformed = self._hearing.malformed.total()
            status = command_status(self._config.vehicle_id, self._watch, malformed)
            self._diagnostics.publish([status], t_s)


def make_nodes(**options: Any) -> Sequence[Node]:
    """Return the node; `options` are those of `rclpy.node.Node`."""
    return [VehicleNode(**options)]


def main() -> None:
    """Run the node."""
    raise SystemExit(main_loop(make_nodes))


if __name__ == "__main__":
    main()
