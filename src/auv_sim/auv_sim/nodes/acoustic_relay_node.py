"""
ROS node of the acoustic medium, in one process with the clock node: together they are the barrier.

In lock-step a tick is done when every agent has published its packets and every vehicle its next state. In
real time the medium is called at every control period of the steady clock. The hulls of lost vehicles drift
on in this node.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile

from auv_core.alarm import Alarm
from auv_core.messages import Packet, VehicleState
from auv_core.params import param
from auv_core.words import listed
from auv_msgs.msg import AcousticEvents, AcousticInbox, AcousticOutbox
from auv_msgs.msg import VehicleState as VehicleStateMsg
from auv_ros.hearing import Hearing
from auv_ros.lifecycle import main_loop
from auv_ros.pace import Pace, tick_clock
from auv_ros.parameters import declare_config
from auv_ros.qos import own_qos
from auv_ros.run_config import RELAY_PHASE, RunConfig
from auv_ros.topic import Topics
from auv_ros.wire import conversions as convert
from auv_ros.wire.acoustics import events_bytes, inbox_bytes, read_outbox
from auv_ros.wire.markers import MARKER_TICKS
from auv_sim.acoustics.medium import AcousticMedium, MediumConfig
from auv_sim.barrier import Barrier
from auv_sim.nodes.adrift import Adrift
from auv_sim.nodes.clock_node import ClockNode
from auv_sim.nodes.link_reports import LinkReports
from auv_sim.nodes.stranger_report import StrangerReport
from auv_sim.run_state import WatchConfig
from auv_sim.silences import ROLES, Silences
from auv_sim.state_watch import StateWatch
from auv_sim.vehicle import VehicleConfig

_STATS_TICKS = 10


@dataclass(frozen=True, kw_only=True)
class FleetConfig:
    """Names of the vehicles, and how old their states may be."""

    vehicle_ids: tuple[str, ...] = param("names of the vehicles in the order of their acoustic addresses")
    state_max_age_s: float = param(
        "age of a vehicle's state above which its modem is silent (s); at least two control periods",
        default=0.5,
        above=0.0,
    )

    def __post_init__(self) -> None:
        """Refuse an empty fleet."""
        if not self.vehicle_ids:
            raise ValueError("vehicle_ids: an empty list is not allowed; allowed: one name per modem")


class AcousticRelayNode(Node):
    """The `AcousticMedium` behind topics; `clock` is the clock node of the same process."""

    def __init__(self, **options: Any) -> None:
        super().__init__("acoustic_relay_node", **options)
        run = declare_config(self, RunConfig)
        medium = declare_config(self, MediumConfig)
        watch = declare_config(self, WatchConfig)
        fleet = declare_config(self, FleetConfig)
        self._ids = fleet.vehicle_ids
        self._period_s = medium.period_s
        self._medium = AcousticMedium(medium)
        self._ticks = tick_clock(run, medium.period_s)
        self._barrier = Barrier(len(self._ids))
        self._watch = StateWatch(self._ids, fleet.state_max_age_s, medium.period_s)
        self._alarm = Alarm(self.get_logger(), "modems silent", "modems speak again")
        self._states: list[VehicleState] = []
        self._newest: dict[int, VehicleState] = {}
        self._outboxes: dict[int, list[Packet]] = {}
        self._silences = Silences(len(self._ids), watch.answer_timeout_s)
        followers = [f"/{name}/{role}" for name in self._ids for role in ROLES]
        self.clock = ClockNode(
            watch,
            self._ticks,
            fleet_size=len(self._ids),
            followers=followers,
            recorded=run.recorded,
            awaited=self._awaited,
            drop=self._drop,
            **options,
        )
        self.clock.on_room = self._try_advance
        topics = self._make_topics(run, self._hulls(watch))
        self._connect(own_qos(admits_strangers=run.admits_strangers))
        self._strangers = StrangerReport(
            self,
            self._reports,
            self._hearing.refused,
            own_nodes=followers,
            vehicle_ids=self._ids,
            are_admitted=run.admits_strangers,
        )
        self._pace = Pace(
            self,
            self._ticks,
            [*topics, *self.clock.topics],
            begin=self._begin,
            act=self._run_free,
            phase=RELAY_PHASE,
            first_tick=self._barrier.tick,
            leads=True,
        )

    def _make_topics(self, run: RunConfig, hulls: dict[int, VehicleConfig]) -> Topics:
        topics = Topics(self, is_recorded=run.recorded)
        self._inboxes = [
            topics.add(
                AcousticInbox,
                f"/{name}/acoustic/rx",
                partial(inbox_bytes, convert.body_frame(name)),
                heard_by=[f"/{name}/agent_node"],
            )
            for name in self._ids
        ]
        self._adrift = Adrift(topics, hulls, self._ticks)
        self._events = topics.add(AcousticEvents, "/acoustic/events", events_bytes)
        self._reports = LinkReports(topics)
        return topics

    def _hulls(self, watch: WatchConfig) -> dict[int, VehicleConfig]:
        """Return the vehicles that the run may lose, by index."""
        if watch.on_vehicle_loss == "stop":
            return {}
        return {i: declare_config(self, VehicleConfig, f"hulls.{name}.") for i, name in enumerate(self._ids)}

    def _connect(self, heard: QoSProfile) -> None:
        on_state, on_outbox = (
            (self._take_state, self._take_outbox)
            if self._ticks.lockstep
            else (self._hear_state, self._hear_outbox)
        )
        self._hearing = Hearing(self)
        listen = self._hearing.listen
        for index, name in enumerate(self._ids):
            listen(VehicleStateMsg, f"/{name}/state", partial(on_state, index), heard)
            listen(AcousticOutbox, f"/{name}/acoustic/tx", partial(on_outbox, index), heard)

    def _begin(self, _: int) -> None:
        if self._ticks.lockstep:
            self._try_advance()
        else:
            self.clock.announce()
            self._strangers.begin(self._report_stamp_s)  # in lock-step the launcher does: bags are equal

    def waits_for(self) -> str:
        """Return as text what the node waits for, or an empty text."""
        owed = self._watch.explained(listed(self._awaited())) if self._pace.ready else ""
        return self._pace.waits_for(self._barrier.tick, owed)

    def _report_stamp_s(self) -> float | None:
        return None if self.clock.done else self._ticks.stamp_s(max(self._barrier.tick, 0))

    def _take_state(self, index: int, data: bytes) -> None:
        """Take an answer in lock-step."""
        state = convert.state_from_bytes(data)
        if self._barrier.state(index, state.tick):
            self._newest[index] = state
            self._try_advance()

    def _take_outbox(self, index: int, data: bytes) -> None:
        """Take an answer in lock-step; its packets wait until the tick is complete."""
        tick, packets = read_outbox(data)
        if self._barrier.outbox(index, tick):
            self._outboxes[index] = packets
            self._try_advance()

    def _try_advance(self) -> None:
        """Begin the next tick of lock-step if all have answered."""
        if not self._barrier.complete or not self._pace.ready:
            return
        if not self.clock.has_room or self.clock.done:
            return
        for index in sorted(self._outboxes):
            self._transmit(index, self._outboxes[index])
        self._states = self._fleet()
        self._newest, self._outboxes = {}, {}
        last, tick = self._barrier.tick, self._barrier.advance()
        self._begin_tick(last, tick)
        if not self.clock.done:
            self._drift()

    def _hear_state(self, index: int, data: bytes) -> None:
        """Take a state in real time."""
        if index in self._adrift.lost:
            return
        self._silences.hear("vehicle_node", index, time.monotonic())
        state = convert.state_from_bytes(data)
        if self._watch.hear(index, state, self._ticks.tick_now_or(state.tick)):
            self._newest[index] = state

    def _hear_outbox(self, index: int, data: bytes) -> None:
        """Take packets in real time."""
        _, packets = read_outbox(data)
        self._silences.hear("agent_node", index, time.monotonic())
        if self._all_known and self._watch.may_send(index, self._ticks.tick_now(), len(packets)):
            self._states = self._fleet()
            self._transmit(index, packets)

    def _run_free(self, tick: int) -> None:
        """Begin the tick of the steady clock."""
        if not self._all_known or self.clock.done:
            return
        if self._barrier.tick < 0:
            self._silences.begin(time.monotonic())
        last = self._barrier.tick
        if tick > last:
            self._drift()
            self._states = self._fleet()
            self._barrier.tick = tick
            self._begin_tick(last, tick)
            self._watch_states(tick)

    def _watch_states(self, tick: int) -> None:
        """Report modems that are silent in real time because their positions are unknown."""
        present = [index for index in range(len(self._ids)) if index not in self._adrift.lost]
        stale = {index: words for index in present if (words := self._watch.why_stale(index, tick))}
        words = listed(list(stale.values()))
        is_new = self._alarm.note(tuple(stale), words, self._ticks.scenario_s(tick))
        if is_new or tick % _STATS_TICKS == 0:
            self._reports.tell_states(words, self._watch, self._ticks.stamp_s(tick))

    @property
    def _all_known(self) -> bool:
        return len(self._newest) == len(self._ids)

    def _fleet(self) -> list[VehicleState]:
        """Return the newest states."""
        return [self._newest[index] for index in range(len(self._ids))]

    def _begin_tick(self, last: int, tick: int) -> None:
        """Begin a tick, and publish the events of the last one."""
        events = self._medium.take_events()
        t_s = self._ticks.stamp_s(tick)
        self.clock.begin_tick(tick)
        if tick % _STATS_TICKS == 0 or self.clock.done:
            self._reports.count(self._medium.links, t_s)
        if not self.clock.done:
            self._deliver(tick, t_s)
        if events:
            self._events.publish(last, events, self._ticks.stamp_s(last), self._ticks.epoch_ns)

    def _deliver(self, tick: int, t_s: float) -> None:
        """Give every modem its inbox."""
        epoch_ns = self._ticks.epoch_ns
        for index, inbox in enumerate(self._medium.exchange(tick, self._states)):
            self._inboxes[index].publish(inbox, t_s, epoch_ns)
            self._reports.note(index, inbox)
        if tick % MARKER_TICKS == 0:
            self._reports.draw(tick, t_s, self._states, self._adrift.markers(self._states, t_s))

    def _transmit(self, index: int, packets: list[Packet]) -> None:
        if packets:
            try:
                self._medium.transmit({index + 1: packets}, self._states)
            except ValueError as error:
                self.get_logger().error(f"{error}: not sent")

    def _awaited(self) -> list[str]:
        if not self._pace.ready:
            return self._pace.missing()
        if self._ticks.lockstep:
            return [self._node_name(role, index) for role, index in self._barrier.owed()]
        if self._barrier.tick < 0:
            return [
                self._node_name("vehicle_node", i) for i in range(len(self._ids)) if i not in self._newest
            ]
        return [self._node_name(role, index) for role, index in self._silent()]

    def _node_name(self, role: str, index: int) -> str:
        return f"/{self._ids[index]}/{role}"

    def _silent(self) -> list[tuple[str, int]]:
        return self._silences.silent(time.monotonic(), without=self._adrift.lost)

    def _drop(self) -> list[str]:
        """Continue without the vehicles that have not answered; return their ids."""
        owed = self._barrier.owed() if self._ticks.lockstep else self._silent()
        vehicles = sorted({index for _, index in owed})
        for index in vehicles:
            self._adrift.lose(index, self._newest.get(index) or self._states[index])
            if self._ticks.lockstep and index not in self._newest:
                self._newest[index] = self._adrift.step(index)
        self._barrier.drop(vehicles)
        return [self._ids[index] for index in vehicles]

    def _drift(self) -> None:
        for index in self._adrift.lost:
            self._newest[index] = self._adrift.step(index)


def make_nodes(**options: Any) -> Sequence[Node]:
    """Return relay and clock; `options` are those of `rclpy.node.Node`."""
    relay = AcousticRelayNode(**options)
    return [relay, relay.clock]


def main() -> None:
    """Run the relay and the clock."""
    raise SystemExit(main_loop(make_nodes))


if __name__ == "__main__":
    main()
