"""
ROS node of one agent: it takes its navigation and its modem's inbox, and publishes a command and packets for
the modem.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from auv_core.alarm import Alarm
from auv_core.messages import Inbox, command_numbers
from auv_core.messages import VehicleState as State
from auv_flocking.agent import Agent
from auv_flocking.agent_config import AgentConfig
from auv_flocking.holding import cause_number
from auv_flocking.mail import Mail
from auv_flocking.nodes.agent_diagnostics import agent_statuses
from auv_flocking.nodes.agent_view import AgentView
from auv_msgs.msg import AcousticInbox, AcousticOutbox, VehicleState
from auv_ros.hearing import Hearing
from auv_ros.lifecycle import main_loop
from auv_ros.pace import Pace, tick_clock
from auv_ros.parameters import declare_config
from auv_ros.qos import own_qos
from auv_ros.run_config import AGENT_PHASE, RunConfig
from auv_ros.topic import Topics
from auv_ros.wire import conversions as convert
from auv_ros.wire.acoustics import outbox_bytes, read_inbox
from auv_ros.wire.commands import command_bytes, command_topic
from auv_ros.wire.diagnostics import diagnostics_bytes

_DIAGNOSTIC_TICKS = 10
_NOT_THIS_TICK = "not of this tick of lock-step"


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
        topics = self._make_topics(run)
        self._hearing = Hearing(self)
        heard = own_qos(admits_strangers=run.admits_strangers)
        self._hearing.listen(VehicleState, "nav", self._on_nav, heard)
        self._hearing.listen(AcousticInbox, "acoustic/rx", self._on_inbox, heard)
        self._pace = Pace(self, self._ticks, topics, begin=self._begin, act=self._run_free, phase=AGENT_PHASE)

    def _make_topics(self, run: RunConfig) -> Topics:
        topics = Topics(self, is_recorded=run.recorded, waits=run.waits)
        name, kind = self._config.vehicle_id, self._agent.command
        self._command = topics.add(
            *command_topic(kind),
            partial(command_bytes, name, kind),
            heard_by=[f"{self.get_namespace().rstrip('/')}/vehicle_node"],
        )
        self._outbox = topics.add(
            AcousticOutbox,
            "acoustic/tx",
            partial(outbox_bytes, convert.body_frame(name)),
            heard_by=["/acoustic_relay_node"],
        )
        self._view = AgentView(topics, self._config, self._agent)
        self._diagnostics = topics.add(DiagnosticArray, "/diagnostics", diagnostics_bytes)
        return topics

    def on_run_end(self) -> None:
        """Stop giving commands."""
        self._pace.stop()

    def waits_for(self) -> str:
        """Return as text what the node waits for, or an empty text."""
        owed = [topic for topic, it in (("nav", self._nav), ("acoustic/rx", self._inbox)) if it is None]
        words = f"{' and '.join(owed)} of tick {self._tick}" if self._ticks.lockstep else ""
        return self._pace.waits_for(self._tick, words)

    def _begin(self, tick: int) -> None:
        self._view.publish_path(self._ticks.stamp_s(0))
        if self._ticks.lockstep:
            self._step_if_ready()
        else:
            self._mail.start(tick)

    def _on_nav(self, data: bytes) -> None:
        nav = convert.state_from_bytes(data)
        if not self._ticks.lockstep:
            self._mail.navs.hear(nav, nav.tick, self._ticks.tick_now_or(nav.tick))
        elif nav.tick == self._tick:
            self._nav = nav
            self._step_if_ready()
        else:
            self._mail.navs.drop(nav.tick, self._tick, _NOT_THIS_TICK)

    def _on_inbox(self, data: bytes) -> None:
        inbox = read_inbox(data, self._ticks.epoch_ns)
        if not self._ticks.lockstep:
            self._mail.hear_inbox(inbox, self._ticks.tick_now_or(inbox.tick))
        elif inbox.tick == self._tick:
            self._inbox = inbox
            self._step_if_ready()
        else:
            self._mail.inboxes.drop(inbox.tick, self._tick, _NOT_THIS_TICK)

    def _step_if_ready(self) -> None:
        nav, inbox, tick = self._nav, self._inbox, self._tick
        if self._pace.ready and nav is not None and inbox is not None:
            self._nav = self._inbox = None
            self._tick += 1
            self._step(tick, nav, inbox)

    def _run_free(self, tick: int) -> None:
        if tick < max(self._tick, 0) or self._mail.awaits_first(tick):
            return
        self._tick = tick + 1
        self._step(tick, self._mail.nav, self._mail.take_inbox())

    def _step(self, tick: int, nav: State | None, inbox: Inbox) -> None:
        scenario_s, t_s = self._ticks.scenario_s(tick), self._ticks.stamp_s(tick)
        command, packets = self._agent.step(scenario_s, nav, inbox)
        self._command.publish(t_s, *command_numbers(command))
        self._outbox.publish(tick, packets, t_s)
        self._view.publish(tick, t_s)
        holding = self._agent.holding
        if self._alarm.note(cause_number(holding), holding, scenario_s) or tick % _DIAGNOSTIC_TICKS == 0:
            malformed = self._hearing.malformed.total()
            statuses = agent_statuses(self._agent, self._config, self._mail, malformed, scenario_s)
            self._diagnostics.publish(statuses, t_s)


def make_nodes(**options: Any) -> Sequence[Node]:
    """Return the node; `options` are those of `rclpy.node.Node`."""
    return [AgentNode(**options)]


def main() -> None:
    """Run the node."""
    raise SystemExit(main_loop(make_nodes))


if __name__ == "__main__":
    main()
