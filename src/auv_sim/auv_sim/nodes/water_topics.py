"""The water of a relay behind topics: packets between modems, and the hulls of lost vehicles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from visualization_msgs.msg import Marker

from auv_core.messages import Packet, VehicleState
from auv_msgs.msg import AcousticEvents, AcousticInbox
from auv_ros.run_config import TickClock
from auv_ros.topic import Topics
from auv_ros.wire.acoustics import events_bytes, inbox_bytes
from auv_ros.wire.conversions import body_frame
from auv_ros.wire.markers import MARKER_TICKS, OBSTACLE, OBSTACLE_DIAMETER_M, sphere
from auv_sim.acoustics.medium import AcousticMedium
from auv_sim.nodes.adrift import Adrift
from auv_sim.nodes.clock_node import ClockNode
from auv_sim.nodes.link_reports import LinkReports
from auv_sim.vehicle import VehicleConfig

STATS_TICKS = 10
"""Ticks between two reports of links and states."""


class WaterTopics:
    """
    The `Water` of a relay: what the medium delivers is published.

    Parameters
    ----------
    topics : Topics
        Of the relay; it gets these.
    vehicle_ids : sequence of str
        Names of the vehicles.
    medium : AcousticMedium
        Carries the packets.
    hulls : mapping of int to VehicleConfig
        The hulls of vehicles that may be lost, by index of the vehicle.
    clock : ClockNode
        Announces ticks, and knows when the run ends.
    ticks : TickClock
        The time of the run.
    logger : rclpy logger
        Of the relay.

    """

    def __init__(
        self,
        topics: Topics,
        vehicle_ids: Sequence[str],
        medium: AcousticMedium,
        hulls: Mapping[int, VehicleConfig],
        clock: ClockNode,
        ticks: TickClock,
        logger: Any,
    ) -> None:
        self._inboxes = [
            topics.add(
                AcousticInbox,
                f"/{name}/acoustic/rx",
                partial(inbox_bytes, body_frame(name)),
                heard_by=[f"/{name}/agent_node"],
            )
            for name in vehicle_ids
        ]
        self._adrift = Adrift(topics, hulls, ticks)
        self._events = topics.add(AcousticEvents, "/acoustic/events", events_bytes)
        self.reports = LinkReports(topics)
        self._medium = medium
        self._clock = clock
        self._ticks = ticks
        self._logger = logger
        self._tick = -1

    def transmit(self, vehicle: int, packets: list[Packet], states: Sequence[VehicleState]) -> None:
        """Send packets of a vehicle, while the fleet is in these states."""
        if packets:
            try:
                self._medium.transmit({vehicle + 1: packets}, states)
            except ValueError as error:
                self._logger.error(f"{error}: not sent")

    def begin_tick(self, tick: int, states: Sequence[VehicleState]) -> bool:
        """Publish a tick, its inboxes, and the events of the last one; return whether the run continues."""
        last, self._tick = self._tick, tick
        events = self._medium.take_events()
        t_s = self._ticks.stamp_s(tick)
        self._clock.begin_tick(tick)
        if tick % STATS_TICKS == 0 or self._clock.done:
            self.reports.count(self._medium.links, t_s)
        if not self._clock.done:
            self._deliver(tick, t_s, states)
        if events:
            self._events.publish(last, events, self._ticks.stamp_s(last), self._ticks.epoch_ns)
        return not self._clock.done

    def lose(self, vehicle: int, state: VehicleState) -> None:
        """Let the hull of a lost vehicle drift, from this state."""
        self._adrift.lose(vehicle, state)

    def drift(self, vehicle: int) -> VehicleState:
        """Publish and return the next state of a hull that drifts."""
        return self._adrift.step(vehicle)

    def _deliver(self, tick: int, t_s: float, states: Sequence[VehicleState]) -> None:
        """Give every modem its inbox."""
        epoch_ns = self._ticks.epoch_ns
        for vehicle, inbox in enumerate(self._medium.exchange(tick, states)):
            self._inboxes[vehicle].publish(inbox, t_s, epoch_ns)
            self.reports.note(vehicle, inbox)
        if tick % MARKER_TICKS == 0:
            others = [*self._adrift.markers(states, t_s), *self._obstacle_markers(tick, t_s)]
            self.reports.draw(tick, t_s, states, others)

    def _obstacle_markers(self, tick: int, t_s: float) -> list[Marker]:
        """Return the obstacles that no agent draws: where those are that vehicles must sense."""
        field = self._medium.obstacles
        if all(field.is_known):
            return []
        places = zip(field.at(self._ticks.scenario_s(tick)), field.is_known, strict=True)
        return [
            sphere("unknown obstacles", number, t_s, place, OBSTACLE_DIAMETER_M, OBSTACLE)
            for number, (place, is_known) in enumerate(places)
            if not is_known
        ]
