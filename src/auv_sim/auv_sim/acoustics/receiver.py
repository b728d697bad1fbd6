"""
One modem as a receiver: which signals reach it and when, which one it locks on to, and their outcomes.

A transmission reaches every other modem as a separate signal, with its own delay, level and interferers. The
position of the receiver when the start arrives determines the start time, and its position when the end
arrives determines the end time. The transmitter's position is that of the moment of sending.

1. A receiver locks on to a signal if it recognises the start above noise and interference, and is neither
   transmitting nor locked on to another signal. It keeps the first one (capture).
2. While it transmits it receives nothing: a signal that overlaps with its own transmission is lost.
3. Signals that overlap with the payload add to the noise during the overlap. Each stretch of equal ratio
   counts with its share of the payload in the packet error probability. One random number per packet and
   receiver decides, and also tells whether noise alone would have caused the loss.
4. A modem without capture loses all signals that overlap with another signal that it could have locked on to.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from auv_core.geometry import Vec3, distance
from auv_core.messages import Outcome, Packet
from auv_sim.acoustics.modem import AcousticModem, LevelModem
from auv_sim.acoustics.outage import PacketLoss
from auv_sim.acoustics.propagation import SoundPropagation
from auv_sim.acoustics.silence import NO_SILENCE, Silence
from auv_sim.streams import Purpose, uniform

# Signals that touch, or overlap by rounding only, do not count as overlapping (s).
TOUCH_S = 1e-8
_SLACK_S = 1e-9
# The smallest number of `uniform` above zero.
_NO_CHANCE = 1e-16


@dataclass(frozen=True, slots=True)
class Transmission:
    """A packet on the air: first and last moment (s) at the transmitter, and its position (m; NED)."""

    packet: Packet
    start_s: float
    end_s: float
    origin: Vec3


@dataclass(slots=True, eq=False)
class Signal:
    """
    A transmission at one receiver.

    `start_s` is NaN until its start has arrived, `end_s` the best estimate of its end (s); `snr_ratio` is
    the ratio of its power to ambient noise (NaN if the modem models no levels).
    """

    transmission: Transmission
    start_s: float = math.nan
    end_s: float = math.nan
    snr_ratio: float = math.nan
    is_audible: bool = True
    is_locked: bool = False
    outcome: Outcome | None = None

    @property
    def snr_db(self) -> float:
        """Signal to ambient noise (dB); NaN if the modem models no levels."""
        return 10.0 * math.log10(max(self.snr_ratio, 1e-300)) if self.snr_ratio >= 0.0 else math.nan

    def overlaps(self, start_s: float, end_s: float) -> bool:
        """Return whether this signal and an interval overlap, by more than rounding."""
        return min(self.end_s, end_s) - max(self.start_s, start_s) > TOUCH_S


class Receiver:
    """The receiver of the modem at one address."""

    def __init__(
        self,
        address: int,
        modem: AcousticModem,
        propagation: SoundPropagation,
        outage: PacketLoss,
        seed: int,
        silence: Silence = NO_SILENCE,
    ) -> None:
        self._address = address
        self._modem = modem
        self._propagation = propagation
        self._outage = outage
        self._silence = silence
        self._seed = seed
        self._levels = modem if isinstance(modem, LevelModem) else None
        self._signals: list[Signal] = []
        self._own: list[tuple[float, float]] = []
        self._lock: Signal | None = None

    @property
    def is_idle(self) -> bool:
        """Whether no signal is on its way to this receiver, and no own transmission could block it."""
        return not self._signals and not self._own

    def expect(self, transmission: Transmission) -> None:
        """Note a transmission of another modem, to any address."""
        self._signals.append(Signal(transmission))

    def go_deaf(self, start_s: float, end_s: float) -> None:
        """Note a transmission of the own modem."""
        if end_s - start_s > TOUCH_S:
            self._own.append((start_s, end_s))

    def hears(self, t_s: float, position: Vec3) -> bool:
        """Return whether a recognisable signal is at `position` (m; NED) at `t_s`."""
        for signal in self._signals:
            sent = signal.transmission
            if signal.outcome is not None or t_s < sent.start_s:
                continue
            delay_s = self._propagation.delay_s(sent.origin, position)
            if sent.start_s + delay_s <= t_s < sent.end_s + delay_s:
                is_audible, snr_ratio = self._level(sent.origin, position)
                if is_audible and self._recognises(snr_ratio):
                    return True
        return False

    def listen(self, now_s: float, position: Vec3) -> Sequence[Signal]:
        """
        Return the signals that ended since the last call, each with its outcome.

        Parameters
        ----------
        now_s : float
            Time of the tick; never earlier than in the last call.
        position : (3,) tuple
            Position of the receiver (m; NED).

        """
        if not self._signals:
            if self._own:
                self._own = [own for own in self._own if own[1] > now_s]
            return ()
        begun, ended = self._advance(now_s, position)
        for signal in begun:
            self._try_lock(signal)
        for signal in ended:
            signal.outcome = self._outcome(signal)
        if ended:
            self._forget(now_s)
        return ended

    def _advance(self, now_s: float, position: Vec3) -> tuple[list[Signal], list[Signal]]:
        """Update start and end times; return the signals that began and those that ended."""
        begun, ended = [], []
        for signal in self._signals:
            sent = signal.transmission
            if signal.outcome is not None or sent.start_s > now_s + _SLACK_S:
                continue
            delay_s = self._propagation.delay_s(sent.origin, position)
            if math.isnan(signal.start_s):
                if sent.start_s + delay_s > now_s + _SLACK_S:
                    continue
                signal.start_s = sent.start_s + delay_s
                signal.is_audible, signal.snr_ratio = self._level(sent.origin, position)
                begun.append(signal)
            signal.end_s = max(sent.end_s + delay_s, signal.start_s)
            if signal.end_s <= now_s + _SLACK_S:
                ended.append(signal)
        begun.sort(key=_order)
        return begun, ended

    def _level(self, origin: Vec3, position: Vec3) -> tuple[bool, float]:
        """Return whether there is a signal, and its ratio of signal to noise power."""
        modem = self._modem
        is_audible = modem.max_range_m == math.inf or distance(origin, position) <= modem.max_range_m
        levels = self._levels
        if levels is None:
            return is_audible, math.nan
        loss_db = self._propagation.loss_db(origin, position, levels.frequency_khz)
        return is_audible, levels.snr_ratio(loss_db)

    def _recognises(self, snr_ratio: float) -> bool:
        return self._levels is None or self._levels.acquires(snr_ratio)

    def _try_lock(self, signal: Signal) -> None:
        """Lock on to a signal at its start, if possible."""
        lock, start_s = self._lock, signal.start_s
        if not signal.is_audible or self._transmits(start_s, start_s + 2.0 * TOUCH_S):
            return
        if lock is not None and lock.end_s - start_s > TOUCH_S and not self._transmits(lock.start_s, start_s):
            return
        if self._levels is not None:
            rivals = self._rivals(signal, start_s, start_s + 2.0 * TOUCH_S)
            interference = sum(rival.snr_ratio for rival in rivals)
            if not self._levels.acquires(signal.snr_ratio / (1.0 + interference)):
                return
        signal.is_locked = True
        self._lock = signal

    def _rivals(self, signal: Signal, start_s: float, end_s: float) -> list[Signal]:
        """Return the other signals that overlap with an interval, by more than rounding."""
        if len(self._signals) == 1 or end_s - start_s <= TOUCH_S:
            return []
        return [
            other
            for other in self._signals
            if other is not signal and other.is_audible and other.overlaps(start_s, end_s)
        ]

    def _transmits(self, start_s: float, end_s: float) -> bool:
        """Return whether the own modem transmits within an interval, by more than rounding."""
        if not self._own:
            return False
        return any(min(own[1], end_s) - max(own[0], start_s) > TOUCH_S for own in self._own)

    def _outcome(self, signal: Signal) -> Outcome:
        if not signal.is_audible:
            return Outcome.RANGE
        if self._transmits(signal.start_s, signal.end_s):
            return Outcome.HALF_DUPLEX
        if not self._recognises(signal.snr_ratio):
            return Outcome.NOISE
        if not signal.is_locked:
            return Outcome.COLLISION
        rivals = self._rivals(signal, signal.start_s, signal.end_s)
        if not self._modem.captures and any(self._recognises(rival.snr_ratio) for rival in rivals):
            return Outcome.COLLISION
        packet = signal.transmission.packet
        event = (packet.source, self._address, packet.sequence)
        if (cause := self._bit_errors(signal, rivals, event)) is not None:
            return cause
        is_lost = self._silence.covers(signal.start_s) or self._outage.lost(*event)
        return Outcome.OUTAGE if is_lost else Outcome.DELIVERED

    def _bit_errors(
        self, signal: Signal, rivals: Sequence[Signal], event: tuple[int, int, int]
    ) -> Outcome | None:
        """Draw whether a packet has a bit error; return its cause, or None."""
        if self._levels is None:
            return None
        quiet = _packet_error_prob(self._levels, signal, ())
        error_prob = _packet_error_prob(self._levels, signal, rivals) if rivals else quiet
        if error_prob < _NO_CHANCE:
            return None
        luck = uniform(self._seed, Purpose.NOISE, *event)
        if luck < quiet:
            return Outcome.NOISE
        return Outcome.COLLISION if luck < error_prob else None

    def _forget(self, now_s: float) -> None:
        """Drop signals that can no longer overlap with others."""
        if self._lock is not None and self._lock.outcome is not None and self._lock.end_s <= now_s:
            self._lock = None
        open_s = min(
            (s.start_s for s in self._signals if s.outcome is None and not math.isnan(s.start_s)),
            default=now_s,
        )
        self._signals = [s for s in self._signals if s.outcome is None or s.end_s > open_s]
        self._own = [own for own in self._own if own[1] > open_s]


def _order(signal: Signal) -> tuple[float, int, int]:
    packet = signal.transmission.packet
    return (signal.start_s, packet.source, packet.sequence)


def _packet_error_prob(modem: LevelModem, signal: Signal, rivals: Sequence[Signal]) -> float:
    """Return the probability of at least one error, with interfering signals while they overlap."""
    size = len(signal.transmission.packet.payload)
    if not rivals:
        return -math.expm1(modem.log_success(signal.snr_ratio, size))
    begin_s, end_s = signal.start_s + modem.preamble_s, signal.end_s
    edges_s = {begin_s, end_s}
    for rival in rivals:
        edges_s.update(t_s for t_s in (rival.start_s, rival.end_s) if begin_s < t_s < end_s)
    times_s = sorted(edges_s)
    log_success = 0.0
    for from_s, to_s in pairwise(times_s):
        middle_s = 0.5 * (from_s + to_s)
        noise = 1.0 + sum(r.snr_ratio for r in rivals if r.start_s <= middle_s < r.end_s)
        share = (to_s - from_s) / (end_s - begin_s)
        log_success += share * modem.log_success(signal.snr_ratio / noise, size)
    return -math.expm1(log_success)
