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
from auv_core.messages import Inbox, Packet, Reception
from auv_core.params import Section, param
from auv_core.plugins import find_plugin

PROPAGATION = "auv_sim.acoustics.propagation"
MODEM = "auv_sim.acoustics.modem"
MAC = "auv_sim.acoustics.mac"
OUTAGE = "auv_sim.acoustics.outage"


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


@dataclass
class LinkCounters:
    """What became of the packets from one modem to another."""

    sent: int = 0
    delivered: int = 0
    lost_outage: int = 0
    lost_range: int = 0


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
        self._flights: list[_Flight] = []
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

    def exchange(self, tick: int, positions: Sequence[Vec3]) -> list[Inbox]:
        """
        Return the inbox of every modem at a tick, in the order of addresses.

        Parameters
        ----------
        tick : int
            The control tick.
        positions : sequence of (3,) tuple
            True positions at the tick (m; NED), in the order of addresses.

        """
        t_s = tick * self._period_s
        arrived: dict[int, list[Reception]] = {address: [] for address in self._addresses}
        waiting = []
        for flight in self._flights:
            receiver = positions[flight.destination - 1]
            arrival_s = flight.end_s + self._propagation.delay_s(flight.origin, receiver)
            if arrival_s > t_s + 1e-9:
                waiting.append(flight)
            else:
                arrived[flight.destination].append(
                    Reception(flight.packet, flight.sent_s, arrival_s, math.nan)
                )
                self.links[flight.packet.source, flight.destination].delivered += 1
        self._flights = waiting
        return [
            Inbox(
                tick,
                self._mac.opportunity_s(address, tick, self._period_s) is not None,
                tuple(
                    sorted(arrived[address], key=lambda r: (r.arrival_s, r.packet.source, r.packet.sequence))
                ),
            )
            for address in self._addresses
        ]

    def transmit(self, packets: Mapping[int, Sequence[Packet]], positions: Sequence[Vec3]) -> None:
        """
        Put on the air what the vehicles handed over in one tick.

        Parameters
        ----------
        packets : mapping of int to sequence of Packet
            By source address; one packet per modem and opportunity, a second one is refused.
        positions : sequence of (3,) tuple
            True positions at that tick (m; NED), in the order of addresses.

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
                self._send(packet, positions)

    def _send(self, packet: Packet, positions: Sequence[Vec3]) -> None:
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
        origin = positions[packet.source - 1]
        for destination in self._addresses:
            if destination == packet.source or packet.destination not in (0, destination):
                continue
            link = self.links[packet.source, destination]
            link.sent += 1
            if distance(origin, positions[destination - 1]) > self._modem.max_range_m:
                link.lost_range += 1
            elif self._outage.lost(packet.source, destination, packet.sequence):
                link.lost_outage += 1
            else:
                self._flights.append(_Flight(packet, destination, start_s, end_s, origin))
