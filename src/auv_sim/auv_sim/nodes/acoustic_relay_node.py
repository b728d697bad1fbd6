"""
ROS node of the acoustic medium; in one process with the clock node, since together they are the lock-step
barrier.

In lock-step a tick is done when every agent has handed over its packets and every vehicle has published its
next state; in real time the medium is asked at every control period of the wall clock.  A vehicle that the
run goes on without drifts on here.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import product
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node
from visualization_msgs.msg import MarkerArray

from auv_core import conversions as convert
from auv_core.acoustic_bytes import events_bytes, inbox_bytes, read_outbox
from auv_core.geometry import Vec3
from auv_core.markers import LINK, LOST_HULL, MARKER_TICKS, lines, sphere
from auv_core.messages import Packet, VehicleState
from auv_core.node_main import (
    EVERY_TICK,
    Audience,
    Rendezvous,
    main_loop,
    now_s,
    publishes_bytes,
    steady_timer,
)
from auv_core.node_params import declare_config
from auv_core.params import param
from auv_core.run_config import RunConfig, TickClock
from auv_msgs.msg import AcousticEvents, AcousticInbox, AcousticLinkStats, AcousticOutbox, AcousticStats
from auv_msgs.msg import VehicleState as VehicleStateMsg
from auv_sim.acoustics.medium import DELAY_EDGES_S, AcousticMedium, MediumConfig
from auv_sim.barrier import Barrier
from auv_sim.nodes.clock_node import ClockNode, WatchConfig
from auv_sim.vehicle import Vehicle, VehicleConfig

_STATS_TICKS = 10
_ROLES = ("agent_node", "vehicle_node")


@dataclass(frozen=True, kw_only=True)
class FleetConfig:
    """Names of the vehicles."""

    vehicle_ids: tuple[str, ...] = param("names of the vehicles in the order of their acoustic addresses")

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
        self._ids = declare_config(self, FleetConfig).vehicle_ids
        self._period_s = medium.period_s
        self._timeout_s = watch.answer_timeout_s
        self._medium = AcousticMedium(medium)
        self._ticks = TickClock(run, medium.period_s, now_s(self))
        self._barrier = Barrier(len(self._ids))
        self._states: dict[int, VehicleState] = {}
        self._next_states: dict[int, VehicleState] = {}
        self._packets: dict[int, list[Packet]] = {}
        self._heard_at_s: dict[tuple[str, int], float] = {}
        self._links: list[tuple[int, int, int]] = []
        self._adrift: dict[int, Vehicle] = {}
        self._hulls: dict[int, VehicleConfig] = {}
        if watch.on_vehicle_loss == "continue":
            self._hulls = {
                i: declare_config(self, VehicleConfig, f"hulls.{name}.") for i, name in enumerate(self._ids)
            }
        self.clock = ClockNode(
            watch,
            self._ticks,
            fleet_size=len(self._ids),
            recorded=run.recorded,
            awaited=self._awaited,
            drop=self._drop,
            **options,
        )
        self.clock.on_room = self._try_advance
        self._connect()
        self._meeting = Rendezvous(self, self._audiences(run), self._start)

    def _connect(self) -> None:
        self._state_stencil = convert.state_stencil()
        self._frames = [convert.body_frame(name) for name in self._ids]
        self._rx_pubs = [
            self.create_publisher(AcousticInbox, f"/{name}/acoustic/rx", EVERY_TICK) for name in self._ids
        ]
        self._publish_inbox = [publishes_bytes(publisher) for publisher in self._rx_pubs]
        self._hull_pubs = {
            i: self.create_publisher(VehicleStateMsg, f"/{self._ids[i]}/state", EVERY_TICK)
            for i in self._hulls
        }
        self._stats_pub = self.create_publisher(AcousticStats, "/acoustic/stats", EVERY_TICK)
        self._events_pub = self.create_publisher(AcousticEvents, "/acoustic/events", EVERY_TICK)
        self._marker_pub = self.create_publisher(MarkerArray, "/markers", EVERY_TICK)
        self._diagnostics_pub = self.create_publisher(DiagnosticArray, "/diagnostics", EVERY_TICK)
        for index, name in enumerate(self._ids):
            self.create_subscription(
                VehicleStateMsg, f"/{name}/state", partial(self._on_state, index), EVERY_TICK, raw=True
            )
            self.create_subscription(
                AcousticOutbox, f"/{name}/acoustic/tx", partial(self._on_outbox, index), EVERY_TICK, raw=True
            )

    def _audiences(self, run: RunConfig) -> list[Audience]:
        recorder = {"/recorder_node"} if run.recorded else set()
        publishers = [self._stats_pub, self._events_pub, self._marker_pub, self._diagnostics_pub]
        publishers += self._hull_pubs.values()
        if self._ticks.lockstep:
            publishers.append(self.clock.clock_pub)
        audiences = [Audience(publisher, frozenset(recorder)) for publisher in publishers]
        for name, publisher in zip(self._ids, self._rx_pubs, strict=True):
            audiences.append(Audience(publisher, frozenset(recorder | {f"/{name}/agent_node"})))
        return audiences

    def _start(self) -> None:
        if self._ticks.lockstep:
            self._try_advance()
        else:
            steady_timer(self, self._period_s, self._run_free)

    def _on_state(self, index: int, data: bytes) -> None:
        if index in self._adrift:
            return
        self._heard_at_s["vehicle_node", index] = time.monotonic()
        state = convert.state_from_bytes(data)
        if not self._ticks.lockstep:
            self._states[index] = state
        elif self._barrier.state(index, state.tick):
            self._next_states[index] = state
            self._try_advance()

    def _on_outbox(self, index: int, data: bytes) -> None:
        self._heard_at_s["agent_node", index] = time.monotonic()
        tick, packets = read_outbox(data)
        if not self._ticks.lockstep:
            self._transmit({index + 1: packets})
        elif self._barrier.outbox(index, tick):
            self._packets[index + 1] = packets
            self._try_advance()

    def _try_advance(self) -> None:
        if self._meeting.ready and self._barrier.complete and self.clock.has_room and not self.clock.ended:
            self._transmit(self._packets)
            self._packets = {}
            self._publish_events(self._barrier.tick)
            self._states, self._next_states = self._next_states, {}
            tick = self._barrier.advance()
            self._begin_tick(tick)
            if not self.clock.ended:
                self._drift()

    def _run_free(self) -> None:
        if len(self._states) < len(self._ids) or self.clock.ended:
            return
        if self._barrier.tick < 0:
            self._ticks.start()
            self._heard_at_s = dict.fromkeys(product(_ROLES, range(len(self._ids))), time.monotonic())
        tick = self._ticks.tick_now()
        if tick <= self._barrier.tick:
            return
        self._drift()
        self._states.update(self._next_states)
        self._publish_events(self._barrier.tick)
        self._barrier.tick = tick
        self._begin_tick(tick)

    def _begin_tick(self, tick: int) -> None:
        self.clock.begin_tick(tick)
        if tick % _STATS_TICKS == 0 or self.clock.ended:
            self._publish_stats(tick)
        if self.clock.ended:
            return
        inboxes = self._medium.exchange(tick, self._fleet())
        t_s = self._ticks.stamp_s(tick)
        for frame, publish, inbox in zip(self._frames, self._publish_inbox, inboxes, strict=True):
            publish(inbox_bytes(frame, inbox, t_s))
        for index, inbox in enumerate(inboxes):
            self._links += [(tick, reception.packet.source - 1, index) for reception in inbox.receptions]
        if tick % MARKER_TICKS == 0:
            self._publish_markers(tick)

    def _transmit(self, packets: dict[int, list[Packet]]) -> None:
        if len(self._states) < len(self._ids):
            return
        fleet = self._fleet()
        for source in sorted(packets):
            try:
                self._medium.transmit({source: packets[source]}, fleet)
            except ValueError as error:
                self.get_logger().error(f"{error}: not sent")

    def _fleet(self) -> list[VehicleState]:
        return [self._states[index] for index in range(len(self._ids))]

    def _publish_events(self, tick: int) -> None:
        events = self._medium.take_events()
        if events:
            self._events_pub.publish(events_bytes(tick, events, self._ticks.stamp_s(tick)))

    def _awaited(self) -> list[str]:
        if not self._meeting.ready:
            return self._meeting.missing()
        if self._ticks.lockstep:
            return [self._node_name(role, index) for role, index in self._barrier.owed()]
        if self._barrier.tick < 0:
            return [
                self._node_name("vehicle_node", i) for i in range(len(self._ids)) if i not in self._states
            ]
        return [self._node_name(role, index) for role, index in self._silent()]

    def _node_name(self, role: str, index: int) -> str:
        return f"/{self._ids[index]}/{role}"

    def _silent(self) -> list[tuple[str, int]]:
        now = time.monotonic()
        return [
            (role, index)
            for (role, index), heard_at_s in self._heard_at_s.items()
            if index not in self._adrift and now - heard_at_s > self._timeout_s
        ]

    def _drop(self) -> list[str]:
        """Go on without the vehicles that owe an answer; return their ids."""
        owed = self._barrier.owed() if self._ticks.lockstep else self._silent()
        vehicles = sorted({index for _, index in owed})
        for index in vehicles:
            hull = Vehicle(self._hulls[index])
            hull.restore(self._next_states.get(index) or self._states[index])
            self._adrift[index] = hull
            if self._ticks.lockstep and index not in self._next_states:
                self._publish_drift(index)
        self._barrier.drop(vehicles)
        return [self._ids[index] for index in vehicles]

    def _drift(self) -> None:
        for index in self._adrift:
            self._publish_drift(index)

    def _publish_drift(self, index: int) -> None:
        state = self._adrift[index].step(None)
        self._next_states[index] = state
        t_s = self._ticks.stamp_s(state.tick)
        self._hull_pubs[index].publish(self._state_stencil.filled(t_s, *convert.state_numbers(state)))

    def _publish_stats(self, tick: int) -> None:
        links = [
            AcousticLinkStats(source=source, destination=destination, **asdict(counters))
            for (source, destination), counters in sorted(self._medium.links.items())
        ]
        t_s = self._ticks.stamp_s(tick)
        stats = AcousticStats(header=convert.header(t_s, ""), delay_edges_s=DELAY_EDGES_S, links=links)
        self._stats_pub.publish(stats)
        sent, delivered = sum(link.sent for link in links), sum(link.delivered for link in links)
        ratio = delivered / sent if sent else math.nan
        status = DiagnosticStatus(
            level=DiagnosticStatus.WARN if sent and not delivered else DiagnosticStatus.OK,
            name="acoustic_relay_node: links",
            message=f"{delivered} of {sent} receptions" if sent else "nothing sent yet",
            hardware_id="acoustic medium",
            values=[KeyValue(key="delivery_ratio", value=f"{ratio:.4f}")],
        )
        self._diagnostics_pub.publish(DiagnosticArray(header=convert.header(t_s, ""), status=[status]))

    def _publish_markers(self, tick: int) -> None:
        t_s = self._ticks.stamp_s(tick)
        self._links = [link for link in self._links if link[0] > tick - 2 * MARKER_TICKS]
        ends: list[Vec3] = []
        for _, source, destination in self._links:
            ends += [self._states[source].position, self._states[destination].position]
        markers = [lines("acoustic links", 0, t_s, ends, LINK, joined=False)]
        for index in sorted(self._adrift):
            diameter_m = 2.0 * self._hulls[index].model.params.hull_radius_m
            markers.append(
                sphere(self._ids[index], 0, t_s, self._states[index].position, diameter_m, LOST_HULL)
            )
        self._marker_pub.publish(MarkerArray(markers=markers))


def make_nodes(**options: Any) -> Sequence[Node]:
    """Return relay and clock; `options` are those of `rclpy.node.Node`."""
    relay = AcousticRelayNode(**options)
    return [relay, relay.clock]


def main() -> None:
    """Run the relay and the clock."""
    raise SystemExit(main_loop(make_nodes))


if __name__ == "__main__":
    main()
