"""
The acoustic medium between the vehicles' modems.

It is called once per control period: `exchange` returns arriving packets and which modems may transmit,
`transmit` takes the packets of the vehicles. Within the period it works in continuous time: a transmission
starts at its medium-access opportunity, ends after its airtime, and is heard range over sound speed later; it
can be delivered from the next tick on. `receiver` models the reception of signals.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from auv_core.geometry import Vec3
from auv_core.messages import AcousticEvent, Inbox, Outcome, Packet, Reception, VehicleState
from auv_core.params import Section, param, same
from auv_core.run_settings import RunSettings
from auv_sim.acoustics.event_log import in_order
from auv_sim.acoustics.links import DELAY_EDGES_S, LinkCounters
from auv_sim.acoustics.mac import SensingAccess, make_mac
from auv_sim.acoustics.modem import make_modem
from auv_sim.acoustics.outage import make_outage
from auv_sim.acoustics.propagation import make_propagation
from auv_sim.acoustics.receiver import TOUCH_S, Receiver, Signal, Transmission
from auv_sim.acoustics.silence import NO_SILENCE, Silence
from auv_sim.acoustics.sonar import make_sonar, none
from auv_sim.obstacle_field import ObstacleConfig, ObstacleField

__all__ = ["DELAY_EDGES_S", "AcousticMedium", "LinkCounters", "MediumConfig"]

PROPAGATION = "auv_sim.acoustics.propagation"
MODEM = "auv_sim.acoustics.modem"
MAC = "auv_sim.acoustics.mac"
OUTAGE = "auv_sim.acoustics.outage"
SONAR = "auv_sim.acoustics.sonar"
NO_SONAR = Section("none", none.Params())


@dataclass(frozen=True, kw_only=True)
class WaterSections:
    """The parts of the medium, as a scenario and a preset have them."""

    propagation: Section = param("travel time and transmission loss", plugins=PROPAGATION)
    modem: Section = param("duration, range and bit errors of packets", plugins=MODEM)
    mac: Section = param("medium access", plugins=MAC)
    outage: Section = param("further random losses", plugins=OUTAGE)
    silence: Silence = param("interval in which no packet arrives", default=NO_SILENCE)
    sonar: Section = param("how vehicles detect each other by sonar", default=NO_SONAR, plugins=SONAR)


@dataclass(frozen=True, kw_only=True)
class MediumConfig(WaterSections):
    """Configuration of the medium: the section of the scenario, and the fleet in it."""

    fleet_size: int = param("number of modems; their addresses are 1 ... fleet_size", minimum=1, maximum=254)
    seed: int = same(RunSettings, "seed")
    period_s: float = same(RunSettings, "period_s")


@dataclass(slots=True)
class _Held:
    """A packet that waits in its modem for a quiet channel; the channel was busy `attempts` times."""

    packet: Packet
    at_s: float
    attempts: int = 0


class AcousticMedium:
    """
    Carry packets between modems with delay and loss.

    The same configuration and the same calls give the same deliveries: there is no clock, and (seed,
    purpose, source, destination, sequence) determine every random number.

    Attributes
    ----------
    links : mapping of (source, destination) to LinkCounters
        Counters of the packets of each link so far.
    obstacles : ObstacleField
        The obstacles, which sonars see.

    """

    def __init__(self, config: MediumConfig, obstacles: Sequence[ObstacleConfig] = ()) -> None:
        self._period_s = config.period_s
        self._addresses = range(1, config.fleet_size + 1)
        propagation = make_propagation(config.propagation)
        self._modem = make_modem(config.modem)
        self._mac = make_mac(config.mac, config.fleet_size, config.seed)
        self._sensing = self._mac if isinstance(self._mac, SensingAccess) else None
        outage = make_outage(config.outage, config.seed)
        self._sonar = make_sonar(config.sonar, config.seed)
        self._sees = config.sonar.kind != NO_SONAR.kind
        self.obstacles = ObstacleField(obstacles)
        self._receivers = [
            Receiver(address, self._modem, propagation, outage, config.seed, config.silence)
            for address in self._addresses
        ]
        self._tick = 0
        self._states: Sequence[VehicleState] = ()
        self._busy_until_s = [-math.inf] * config.fleet_size
        self._held: dict[int, _Held] = {}
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
            The control tick, never earlier than in the last call.
        states : sequence of VehicleState
            True states at the tick, in the order of addresses.

        """
        now_s = tick * self._period_s
        if self._held:
            self._send_held(now_s)
        self._tick, self._states = tick, states
        contacts = self._sonar.contacts if self._sees else _sees_nothing
        obstacles = self.obstacles.at(now_s) if self._sees else ()
        return [
            Inbox(
                tick,
                self._asks(address, tick),
                () if receiver.is_idle else self._deliver(address, now_s, states[address - 1].position),
                contacts(address, tick, self._period_s, states, obstacles),
            )
            for address, receiver in zip(self._addresses, self._receivers, strict=True)
        ]

    def transmit(self, packets: Mapping[int, Sequence[Packet]], states: Sequence[VehicleState]) -> None:
        """
        Take the packets that the vehicles pass in one tick.

        A packet that comes after the next tick has begun, as may happen in real time, starts when it comes.

        Parameters
        ----------
        packets : mapping of int to sequence of Packet
            By source address; one packet per modem and opportunity, a second one is refused.
        states : sequence of VehicleState
            True states at that tick, in the order of addresses.

        Raises
        ------
        ValueError
            For a packet without a transmit opportunity, with a wrong source or an unknown destination, a
            second packet, or a payload that is too large for the modem.

        """
        self._states = states
        for source in sorted(packets):
            if len(packets[source]) > 1:
                raise ValueError(
                    f"modem {source} got {len(packets[source])} packets in one tick; it takes one at a time"
                )
            for packet in packets[source]:
                self._check_addresses(source, packet)
                start_s = self._start_s(packet)
                if self._sensing is not None:
                    self._held[source] = _Held(packet, start_s)
                else:
                    self._send(packet, start_s)

    def take_events(self) -> list[AcousticEvent]:
        """Return the acoustic log since the last call, in its order."""
        taken, self._events = self._events, []
        return in_order(taken)

    def _asks(self, address: int, tick: int) -> bool:
        """Return whether a modem asks for data in a tick: it may transmit, is idle, and has no packet."""
        start_s = self._mac.opportunity_s(address, tick, self._period_s)
        return (
            start_s is not None
            and start_s >= self._busy_until_s[address - 1] - TOUCH_S
            and address not in self._held
        )

    def _check_addresses(self, source: int, packet: Packet) -> None:
        if source not in self._addresses or packet.source != source:
            raise ValueError(f"modem {source} was handed a packet of modem {packet.source}")
        if packet.destination != 0 and packet.destination not in self._addresses:
            raise ValueError(
                f"modem {source} was handed a packet for modem {packet.destination}, which is not there"
            )

    def _start_s(self, packet: Packet) -> float:
        """Return when the modem will begin to transmit a packet (s), or refuse the packet."""
        source, size = packet.source, len(packet.payload)
        start_s = self._mac.opportunity_s(source, packet.tick, self._period_s)
        if start_s is None:
            raise ValueError(
                f"modem {source} was handed a packet in tick {packet.tick}, in which it may not transmit"
            )
        if size > self._modem.max_payload_bytes:
            raise ValueError(
                f"modem {source} was handed {size} bytes; it takes {self._modem.max_payload_bytes}"
            )
        if packet.tick < self._tick:
            start_s = max(start_s, self._tick * self._period_s)
        if source in self._held or start_s < self._busy_until_s[source - 1] - TOUCH_S:
            raise ValueError(
                f"modem {source} was handed a packet in tick {packet.tick}, in which it still has another one"
            )
        return start_s

    def _send_held(self, until_s: float) -> None:
        """Let modems with carrier sense listen, in the order of time, up to a moment."""
        while self._held and self._sensing is not None:
            source, held = min(self._held.items(), key=lambda item: (item[1].at_s, item[0]))
            if held.at_s >= until_s:
                return
            if self._receivers[source - 1].hears(held.at_s, self._states[source - 1].position):
                held.attempts += 1
                held.at_s += self._sensing.backoff_s(source, held.packet.sequence, held.attempts)
            else:
                del self._held[source]
                self._send(held.packet, held.at_s)

    def _send(self, packet: Packet, start_s: float) -> None:
        """Put a packet on the air."""
        source, size = packet.source, len(packet.payload)
        end_s = start_s + self._modem.airtime_s(size)
        transmission = Transmission(packet, start_s, end_s, self._states[source - 1].position)
        self._busy_until_s[source - 1] = end_s
        self._events.append(
            AcousticEvent(
                Outcome.SENT, source, packet.destination, packet.sequence, start_s, end_s, math.nan, size
            )
        )
        for address, receiver in zip(self._addresses, self._receivers, strict=True):
            if address == source:
                receiver.go_deaf(start_s, end_s)
                continue
            receiver.expect(transmission)
            if packet.destination in (0, address):
                self.links[source, address].count_sent(size)

    def _deliver(self, address: int, now_s: float, position: Vec3) -> tuple[Reception, ...]:
        """Return the packets that arrived at a modem since the last tick, in the order of arrival."""
        signals = self._receivers[address - 1].listen(now_s, position)
        if not signals:
            return ()
        receptions = []
        for signal in signals:
            packet = signal.transmission.packet
            if packet.destination not in (0, address):
                continue
            self._note(address, signal)
            if signal.outcome is Outcome.DELIVERED:
                receptions.append(Reception(packet, signal.transmission.start_s, signal.end_s, signal.snr_db))
        return tuple(sorted(receptions, key=lambda r: (r.arrival_s, r.packet.source, r.packet.sequence)))

    def _note(self, address: int, signal: Signal) -> None:
        """Count and log the end of a packet at a receiver."""
        sent, outcome = signal.transmission, signal.outcome
        if outcome is None:
            raise RuntimeError("a signal that has not ended has no outcome")
        packet = sent.packet
        self.links[packet.source, address].count_end(outcome, signal.end_s - sent.start_s)
        self._events.append(
            AcousticEvent(
                outcome, packet.source, address, packet.sequence,
                signal.start_s, signal.end_s, signal.snr_db, len(packet.payload),
            )
        )  # fmt: skip


def _sees_nothing(*_: object) -> tuple[()]:
    return ()
