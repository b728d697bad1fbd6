"""
The acoustic medium: everything between the vehicles' modems.

The medium is asked once per control period: what arrives now (`deliver`), who may transmit (`ready`), and
what is handed over (`transmit`).  Inside the period it works on continuous time: a transmission starts at
its medium-access opportunity, ends after its airtime, and is heard range over sound speed later; it can be
delivered from the next tick on.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from auv_core.geometry import Vec3, distance
from auv_core.messages import AcousticEvent, Inbox, Outcome, Packet, Reception, VehicleState
from auv_core.params import Section, param
from auv_core.plugins import find_plugin
from auv_sim.acoustics.links import DELAY_EDGES_S, LinkCounters
from auv_sim.acoustics.sonar import none

__all__ = ["DELAY_EDGES_S", "AcousticMedium", "LinkCounters", "MediumConfig"]

PROPAGATION = "auv_sim.acoustics.propagation"
MODEM = "auv_sim.acoustics.modem"
MAC = "auv_sim.acoustics.mac"
OUTAGE = "auv_sim.acoustics.outage"
SONAR = "auv_sim.acoustics.sonar"
NO_SONAR = Section("none", none.Params())


@dataclass(frozen=True, kw_only=True)
class MediumConfig:
    """Everything that the medium needs to know."""

    fleet_size: int = param("number of modems; their addresses are 1 ... fleet_size", minimum=1, maximum=254)
    seed: int = param("seed of every random number", default=1, minimum=0)
    period_s: float = param("control period (s)", default=0.1, above=0.0)
    propagation: Section = param("travel time", plugins=PROPAGATION)
    modem: Section = param("airtime and reach", plugins=MODEM)
    mac: Section = param("medium access", plugins=MAC)
    outage: Section = param("losses by no other cause", plugins=OUTAGE)
    sonar: Section = param("what the vehicles see of each other", default=NO_SONAR, plugins=SONAR)


@dataclass(frozen=True)
class _Flight:
    """A transmission on its way to one receiver."""

    packet: Packet
    destination: int
    sent_s: float
    end_s: float
    origin: Vec3


class AcousticMedium:
    """
    Carry packets between modems with delay and loss.

    The same configuration and the same calls give the same deliveries: no clock, and every random number is
    fixed by (seed, purpose, source, destination, sequence).
    """

    def __init__(self, config: MediumConfig) -> None:
        self._period_s = config.period_s
        self._addresses = range(1, config.fleet_size + 1)
        self._propagation = find_plugin(PROPAGATION, config.propagation.kind).Propagation(
            config.propagation.params
        )
        self._modem = find_plugin(MODEM, config.modem.kind).Modem(config.modem.params)
        self._mac = find_plugin(MAC, config.mac.kind).Mac(config.mac.params, config.fleet_size)
        self._outage = find_plugin(OUTAGE, config.outage.kind).Outage(config.outage.params, config.seed)
        self._sonar = find_plugin(SONAR, config.sonar.kind).Sonar(config.sonar.params, config.seed)
        self._flights: list[_Flight] = []
        self._events: list[AcousticEvent] = []
        self.links: defaultdict[tuple[int, int], LinkCounters] = defaultdict(LinkCounters)

    def check_payload(self, payload_bytes: int) -> None:
        """
        Refuse a payload that this modem cannot carry in its turn.

        Raises
        ------
        ValueError
            With a message ``modem.params...`` or ``mac.params...`` that names the limit.

        """
        if payload_bytes > self._modem.max_payload_bytes:
            raise ValueError(
                f"modem.params.max_payload_bytes: {self._modem.max_payload_bytes} is not allowed; "
                f"allowed: at least the {payload_bytes} bytes of a report"
            )
        try:
            self._mac.check(self._modem.airtime_s(payload_bytes))
        except ValueError as error:
            raise ValueError(f"mac.params.{error}") from None

    def exchange(self, tick: int, states: Sequence[VehicleState]) -> list[Inbox]:
        """
        Return the inbox of every modem at a tick, in the order of addresses.

        Parameters
        ----------
        tick : int
            The control tick.
        states : sequence of VehicleState
            True states at the tick, in the order of addresses.

        """
        t_s = tick * self._period_s
        arrived: dict[int, list[Reception]] = {address: [] for address in self._addresses}
        waiting = []
        for flight in self._flights:
            receiver = states[flight.destination - 1].position
            arrival_s = flight.end_s + self._propagation.delay_s(flight.origin, receiver)
            if arrival_s > t_s + 1e-9:
                waiting.append(flight)
            else:
                arrived[flight.destination].append(
                    Reception(flight.packet, flight.sent_s, arrival_s, math.nan)
                )
                self._end(Outcome.DELIVERED, flight, arrival_s)
        self._flights = waiting
        return [
            Inbox(
                tick,
                self._mac.opportunity_s(address, tick, self._period_s) is not None,
                tuple(
                    sorted(arrived[address], key=lambda r: (r.arrival_s, r.packet.source, r.packet.sequence))
                ),
                self._sonar.contacts(address, tick, self._period_s, states),
            )
            for address in self._addresses
        ]

    def transmit(self, packets: Mapping[int, Sequence[Packet]], states: Sequence[VehicleState]) -> None:
        """
        Put on the air what the vehicles handed over in one tick.

        Parameters
        ----------
        packets : mapping of int to sequence of Packet
            By source address; one packet per modem and opportunity, a second one is refused.
        states : sequence of VehicleState
            True states at that tick, in the order of addresses.

        Raises
        ------
        ValueError
            For a packet out of turn, a second packet, or a payload that the modem does not take.

        """
        for source in sorted(packets):
            if len(packets[source]) > 1:
                raise ValueError(
                    f"modem {source} got {len(packets[source])} packets in one tick; it takes one at a time"
                )
            for packet in packets[source]:
                self._send(packet, states)

    def _send(self, packet: Packet, states: Sequence[VehicleState]) -> None:
        start_s = self._mac.opportunity_s(packet.source, packet.tick, self._period_s)
        if start_s is None:
            raise ValueError(
                f"modem {packet.source} was handed a packet in tick {packet.tick}, where it may not transmit"
            )
        if len(packet.payload) > self._modem.max_payload_bytes:
            raise ValueError(
                f"modem {packet.source} was handed {len(packet.payload)} bytes; "
                f"it takes {self._modem.max_payload_bytes}"
            )
        end_s = start_s + self._modem.airtime_s(len(packet.payload))
        origin = states[packet.source - 1].position
        self._events.append(
            AcousticEvent(
                Outcome.SENT, packet.source, packet.destination, packet.sequence,
                start_s, end_s, math.nan, len(packet.payload),
            )
        )  # fmt: skip
        for destination in self._addresses:
            if destination == packet.source or packet.destination not in (0, destination):
                continue
            self.links[packet.source, destination].count_sent(len(packet.payload))
            flight = _Flight(packet, destination, start_s, end_s, origin)
            receiver = states[destination - 1].position
            arrival_s = end_s + self._propagation.delay_s(origin, receiver)
            if distance(origin, receiver) > self._modem.max_range_m:
                self._end(Outcome.RANGE, flight, arrival_s)
            elif self._outage.lost(packet.source, destination, packet.sequence):
                self._end(Outcome.OUTAGE, flight, arrival_s)
            else:
                self._flights.append(flight)

    def _end(self, outcome: Outcome, flight: _Flight, arrival_s: float) -> None:
        packet = flight.packet
        size_bytes = len(packet.payload)
        start_s = arrival_s - (flight.end_s - flight.sent_s)
        self.links[packet.source, flight.destination].count_end(outcome, arrival_s - flight.sent_s)
        self._events.append(
            AcousticEvent(
                outcome, packet.source, flight.destination, packet.sequence,
                start_s, arrival_s, math.nan, size_bytes,
            )
        )  # fmt: skip

    def take_events(self) -> list[AcousticEvent]:
        """Return the acoustic log since the last call."""
        taken, self._events = self._events, []
        return sorted(taken, key=lambda e: (e.end_s, e.source, e.sequence, e.destination))
