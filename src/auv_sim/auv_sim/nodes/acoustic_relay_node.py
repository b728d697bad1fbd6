"""
ROS node of the acoustic medium, in one process with the clock node.

`LockStepRelay` or `RealTimeRelay` decides when a tick begins; `WaterTopics` publishes what the tick brings.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial
from typing import Any

from rclpy.node import Node

from auv_core.words import listed
from auv_msgs.msg import AcousticOutbox, VehicleState
from auv_ros.hearing import Hearing
from auv_ros.lifecycle import main_loop
from auv_ros.pace import Pace, tick_clock
from auv_ros.parameters import declare_config
from auv_ros.qos import own_qos
from auv_ros.run_config import RELAY_PHASE, RunConfig
from auv_ros.topic import Topics
from auv_ros.wire.acoustics import read_outbox
from auv_ros.wire.conversions import state_from_bytes
from auv_sim.acoustics.medium import AcousticMedium, MediumConfig
from auv_sim.nodes.clock_node import ClockNode
from auv_sim.nodes.state_report import StateReport
from auv_sim.nodes.stranger_report import StrangerReport
from auv_sim.nodes.water_topics import WaterTopics
from auv_sim.obstacle_field import ObstacleConfig
from auv_sim.relay import Relay
from auv_sim.relay.fleet_config import FleetConfig
from auv_sim.relay.lock_step import LockStepRelay
from auv_sim.relay.real_time import RealTimeRelay
from auv_sim.relay.silences import ROLES, Silences
from auv_sim.relay.state_watch import StateWatch
from auv_sim.run_state import WatchConfig
from auv_sim.vehicle import VehicleConfig


class AcousticRelayNode(Node):
    """The relay behind topics; `clock` is the clock node of the same process."""

    def __init__(self, **options: Any) -> None:
        super().__init__("acoustic_relay_node", **options)
        run = declare_config(self, RunConfig)
        config = declare_config(self, MediumConfig)
        watch = declare_config(self, WatchConfig)
        fleet = declare_config(self, FleetConfig)
        medium = AcousticMedium(config, self._obstacles(fleet.obstacle_count))
        self._ids = fleet.vehicle_ids
        self._ticks = tick_clock(run, config.period_s)
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
        topics = Topics(self, is_recorded=run.recorded)
        water = WaterTopics(
            topics,
            self._ids,
            medium,
            self._hulls(watch),
            self.clock,
            self._ticks,
            self.get_logger(),
        )
        self._states = StateWatch(self._ids, fleet.state_max_age_s, config.period_s)
        self._relay = self._make_relay(water, watch.answer_timeout_s)
        if self._ticks.lockstep:
            self.clock.on_room = self._relay.advance
        self._hearing = Hearing(self)
        listen, heard = self._hearing.listen, own_qos(admits_strangers=run.admits_strangers)
        for vehicle, name in enumerate(self._ids):
            listen(VehicleState, f"/{name}/state", partial(self._on_state, vehicle), heard)
            listen(AcousticOutbox, f"/{name}/acoustic/tx", partial(self._on_outbox, vehicle), heard)
        self._state_report = StateReport(self.get_logger(), water.reports, self._states, self._ticks)
        self._strangers = StrangerReport(
            self,
            water.reports,
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
            first_tick=self._relay.tick,
            leads=True,
        )

    def waits_for(self) -> str:
        """Return as text what the node waits for, or an empty text."""
        owed = self._states.explained(listed(self._awaited())) if self._pace.ready else ""
        return self._pace.waits_for(self._relay.tick, owed)

    def _make_relay(self, water: WaterTopics, answer_timeout_s: float) -> Relay:
        count = len(self._ids)
        if self._ticks.lockstep:
            return LockStepRelay(count, water, self._may_begin)
        silences = Silences(count, answer_timeout_s)
        return RealTimeRelay(water, self._states, silences, self._ticks, time.monotonic, self._may_begin)

    def _hulls(self, watch: WatchConfig) -> dict[int, VehicleConfig]:
        """Return the vehicles that the run may lose, by index."""
        if watch.on_vehicle_loss == "stop":
            return {}
        return {i: declare_config(self, VehicleConfig, f"hulls.{name}.") for i, name in enumerate(self._ids)}

    def _obstacles(self, count: int) -> list[ObstacleConfig]:
        return [declare_config(self, ObstacleConfig, f"obstacles.o{number}.") for number in range(count)]

    def _begin(self, _: int) -> None:
        if self._ticks.lockstep:
            self._relay.advance()
        else:
            self.clock.announce()
            self._strangers.begin(self._report_stamp_s)  # in lock-step the launcher does: bags are equal

    def _on_state(self, vehicle: int, data: bytes) -> None:
        self._relay.hear_state(vehicle, state_from_bytes(data))

    def _on_outbox(self, vehicle: int, data: bytes) -> None:
        self._relay.hear_packets(vehicle, *read_outbox(data))

    def _run_free(self, _: int) -> None:
        if self._relay.advance():
            self._state_report.tell(self._relay.tick, without=self._relay.lost)

    def _may_begin(self) -> bool:
        return self._pace.ready and self.clock.has_room and not self.clock.done

    def _report_stamp_s(self) -> float | None:
        return None if self.clock.done else self._ticks.stamp_s(max(self._relay.tick, 0))

    def _awaited(self) -> list[str]:
        if not self._pace.ready:
            return self._pace.missing()
        return [f"/{self._ids[vehicle]}/{role}" for role, vehicle in self._relay.owed()]

    def _drop(self) -> list[str]:
        """Continue without the vehicles that have not answered; return their ids."""
        return [self._ids[vehicle] for vehicle in self._relay.drop()]


def make_nodes(**options: Any) -> Sequence[Node]:
    """Return relay and clock; `options` are those of `rclpy.node.Node`."""
    relay = AcousticRelayNode(**options)
    return [relay, relay.clock]


def main() -> None:
    """Run the relay and the clock."""
    raise SystemExit(main_loop(make_nodes))


if __name__ == "__main__":
    main()
