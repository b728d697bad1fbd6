"""The messages of a run by vehicle and tick, as a bag gives them."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from auv_bag.bag import Bag
from auv_bag.topics import STATUS_TOPIC
from auv_bag.writer import BagError
from auv_core.messages import Outcome
from auv_experiment.tick_series import TickSeries
from auv_flocking.holding import cause_number
from auv_flocking.neighbours.estimates import AGE, COVARIANCE, POSITION, PUBLISHED, SONAR_AGE

FloatArray = NDArray[np.float64]

_MORE_TICKS = 1000
"""So many ticks before and after its own a run in real time can have: it ends when it wakes up."""
_EPOCH_STATES = 1000
_OUTCOMES = frozenset(Outcome)
_EVENTS_TOPIC = "/acoustic/events"


class _ForeignError(ValueError):
    """A message of something that the run does not have."""


class RunMessages:
    """Collects the messages of a run by vehicle and tick."""

    def __init__(self, vehicle_ids: list[str], period_s: float, most_ticks: int) -> None:
        self._last_tick = most_ticks + _MORE_TICKS
        self.left_out: Counter[str] = Counter()
        self.off_time = ""
        self._ids = vehicle_ids
        self._period_s = period_s
        n = len(vehicle_ids)
        self.state = [TickSeries(13) for _ in range(n)]
        self.nav = [TickSeries(4) for _ in range(n)]
        self.command = [TickSeries(6) for _ in range(n)]
        self.reference = [TickSeries(3) for _ in range(n)]
        self.centre = [TickSeries(6) for _ in range(n)]
        self.law_state: dict[tuple[int, int], list[float]] = {}
        self.holding: dict[tuple[int, int], int] = {}
        self.neighbours = [TickSeries(n * PUBLISHED) for _ in range(n)]
        self.sent: list[tuple[int, int, int]] = []
        self.received: list[tuple[int, int, int, int, float]] = []
        self.contacts: list[tuple[int, int, float, float, float]] = []
        self.events: list[tuple[Any, ...]] = []
        self.lost: set[str] = set()
        self._epoch_ns = 0

    def read(self, bag: Bag) -> None:
        """Take every message that an array is made of."""
        self._epoch_ns = self._find_epoch_ns(bag)
        handlers = self._handlers()
        for message in bag.messages(handlers.keys() & bag.topics.keys()):
            try:
                decoded = bag.decode(message)
            except BagError:
                self.left_out[message.topic] += 1
                continue
            try:
                handlers[message.topic](decoded)
            except _ForeignError as error:
                self.left_out[message.topic] += 1
                self.off_time = self.off_time or str(error)

    def _find_epoch_ns(self, bag: Bag) -> int:
        """
        Return the stamp of tick 0 (ns): wall time in a real-time run.

        It is what the first states say of most vehicles and ticks, since some may be a stranger's, and older
        runs in real time stamped tick 0 with 0.
        """
        epochs_ns: defaultdict[int, dict[tuple[str, int], int]] = defaultdict(dict)
        for message in islice(bag.messages({f"/{name}/state" for name in self._ids}), _EPOCH_STATES):
            with suppress(BagError):
                state = bag.decode(message)
                epoch_ns = _nanoseconds(state.header.stamp) - self._since_epoch_ns(state.tick)
                epochs_ns[round(epoch_ns * 1e-6)][message.topic, state.tick] = epoch_ns
        likeliest = max(epochs_ns.values(), key=len, default={})
        return next(reversed(likeliest.values()), 0)

    def _check_time(self, i: int, state: Any) -> None:
        """Leave out a state whose tick and stamp are not of the run's one time line."""
        stamp_ns = _nanoseconds(state.header.stamp)
        off_ns = stamp_ns - self._epoch_ns - self._since_epoch_ns(state.tick)
        is_of_old_run = state.tick == stamp_ns == 0
        if abs(off_ns) > 0.5e9 * self._period_s and not is_of_old_run:
            raise _ForeignError(
                f"/{self._ids[i]}/state of tick {state.tick} is stamped "
                f"{abs(off_ns) * 1e-9:.3f} s {'late' if off_ns > 0 else 'early'}"
            )

    def _since_epoch_ns(self, tick: int) -> int:
        return round(tick * self._period_s * 1e9)

    def _handlers(self) -> dict[str, Callable[[Any], None]]:
        """Return what to do with a message, by topic."""
        handlers: dict[str, Callable[[Any], None]] = {
            STATUS_TOPIC: self._take_status,
            _EVENTS_TOPIC: self._take_events,
        }
        for i, name in enumerate(self._ids):
            for topic, take in {
                "state": self._take_state,
                "nav": self._take_nav,
                "cmd_wrench": self._take_wrench,
                "cmd_vel": self._take_velocity_command,
                "reference": self._take_reference,
                "flocking_centre": self._take_centre,
                "control_status": self._take_control_status,
                "neighbours": self._take_neighbours,
                "acoustic/tx": self._take_sent,
                "acoustic/rx": self._take_received,
            }.items():
                handlers[f"/{name}/{topic}"] = partial(take, i)
        return handlers

    def _tick(self, stamp: Any) -> int:
        return self._known(round((_nanoseconds(stamp) - self._epoch_ns) * 1e-9 / self._period_s))

    def _known(self, tick: int) -> int:
        """Return a tick that the run can have."""
        if not -_MORE_TICKS <= tick <= self._last_tick:
            raise _ForeignError
        return tick

    def _index(self, address: int) -> int:
        """Return the place of the vehicle with an address."""
        if not 1 <= address <= len(self._ids):
            raise _ForeignError
        return address - 1

    def _scenario_s(self, stamp: Any) -> float:
        return (_nanoseconds(stamp) - self._epoch_ns) * 1e-9

    def _take_state(self, i: int, state: Any) -> None:
        tick = self._known(state.tick)
        self._check_time(i, state)
        p, q = state.pose.position, state.pose.orientation
        v, w = state.twist.linear, state.twist.angular
        self.state[i].values[tick] = np.array(
            [p.x, p.y, p.z, q.w, q.x, q.y, q.z, v.x, v.y, v.z, w.x, w.y, w.z]
        )

    def _take_nav(self, i: int, nav: Any) -> None:
        self.nav[i].values[self._known(nav.tick)] = np.array([*_xyz(nav.pose.position), nav.position_sd_m])

    def _take_wrench(self, i: int, command: Any) -> None:
        force, torque = command.wrench.force, command.wrench.torque
        self.command[i].values[self._tick(command.header.stamp)] = np.array(_xyz(force) + _xyz(torque))

    def _take_velocity_command(self, i: int, command: Any) -> None:
        linear, angular = command.twist.linear, command.twist.angular
        self.command[i].values[self._tick(command.header.stamp)] = np.array(_xyz(linear) + _xyz(angular))

    def _take_reference(self, i: int, reference: Any) -> None:
        self.reference[i].values[self._tick(reference.header.stamp)] = np.array(_xyz(reference.twist.linear))

    def _take_centre(self, i: int, centre: Any) -> None:
        self.centre[i].values[self._known(centre.tick)] = np.array(
            _xyz(centre.position) + _xyz(centre.velocity)
        )

    def _take_control_status(self, i: int, status: Any) -> None:
        tick = self._known(status.tick)
        if len(status.law_state):
            self.law_state[tick, i] = list(status.law_state)
        if status.holding:
            self.holding[tick, i] = cause_number(status.holding)

    def _take_neighbours(self, i: int, message: Any) -> None:
        table = np.full((len(self._ids), PUBLISHED), np.nan)
        for estimate in message.neighbours:
            row = table[self._index(estimate.address)]
            row[POSITION:COVARIANCE] = _xyz(estimate.position) + _xyz(estimate.velocity)
            row[COVARIANCE:AGE] = estimate.covariance
            row[AGE], row[SONAR_AGE] = estimate.age_s, estimate.sonar_age_s
        self.neighbours[i].values[self._known(message.tick)] = table.reshape(-1)

    def _take_sent(self, _: int, outbox: Any) -> None:
        self.sent += [
            (self._known(packet.tick), 1 + self._index(packet.source), packet.sequence)
            for packet in outbox.packets
        ]

    def _take_received(self, i: int, inbox: Any) -> None:
        tick = self._known(inbox.tick)
        self.received += [
            (tick, 1 + self._index(each.packet.source), i + 1, each.packet.sequence, _delay_s(each))
            for each in inbox.receptions
        ]
        self.contacts += [(tick, i + 1, c.range_m, c.bearing_rad, c.elevation_rad) for c in inbox.contacts]

    def _take_events(self, message: Any) -> None:
        tick = self._known(message.tick)
        self.events += [
            (tick, *self._event_keys(e), *self._event_times_s(e), e.snr_db) for e in message.events
        ]

    def _event_times_s(self, e: Any) -> tuple[float, float]:
        if hasattr(e, "start_s"):  # a bag of before the times were stamps
            return e.start_s, e.end_s
        return self._scenario_s(e.start), self._scenario_s(e.end)

    def _event_keys(self, e: Any) -> tuple[int, ...]:
        """Return what an event is of, and of whom."""
        self._index(e.source)
        if e.destination:
            self._index(e.destination)
        if e.outcome not in _OUTCOMES:
            raise _ForeignError
        return e.outcome, e.source, e.destination, e.sequence, e.size_bytes

    def _take_status(self, status: Any) -> None:
        self.lost = set(status.lost_vehicles)  # the clock repeats a loss: what the next one lacks is forged


def _nanoseconds(stamp: Any) -> int:
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def _delay_s(reception: Any) -> float:
    """Return the time from the start of a transmission to the end of its reception (s)."""
    if hasattr(reception, "sent_s"):  # a bag of before the times were stamps
        return float(reception.arrival_s - reception.sent_s)
    return (_nanoseconds(reception.arrival) - _nanoseconds(reception.sent)) * 1e-9


def _xyz(vector: Any) -> list[float]:
    """Return the components of a Point or Vector3."""
    return [vector.x, vector.y, vector.z]
