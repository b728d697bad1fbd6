"""The messages of a bag by vehicle and tick."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from auv_bag.bag import Bag
from auv_bag.columns import Batch, Columns
from auv_bag.topics import STATUS_TOPIC
from auv_core.messages import Outcome
from auv_experiment.run_time_line import Flags, RunTimeLine, nanoseconds, seconds
from auv_experiment.tick_series import FloatArray, RecordedRows, TickSeries
from auv_flocking.holding import cause_number
from auv_flocking.neighbours.estimates import AGE, COVARIANCE, POSITION, PUBLISHED, SONAR_AGE

_EVENTS_TOPIC = "/acoustic/events"
_END_OF_TIME = (2**64, 0)


class _Taking(NamedTuple):
    """Handler of messages of vehicle i: which belong to this run, and where they are stored."""

    are_ours: Callable[[int, Batch], Flags]
    take: Callable[[int, Batch], None]
    i: int


class RunMessages:
    """Collects the messages of a run by vehicle and tick."""

    def __init__(self, bag: Bag, vehicle_ids: Sequence[str], period_s: float, most_ticks: int) -> None:
        self.left_out: Counter[str] = Counter()
        self.off_time = ""
        self._off_time_at = _END_OF_TIME
        self._ids = vehicle_ids
        self._period_s = period_s
        n = len(vehicle_ids)
        self.state = [TickSeries(13) for _ in range(n)]
        self.nav = [TickSeries(4) for _ in range(n)]
        self.command = [TickSeries() for _ in range(n)]
        self.actuator_output = [TickSeries() for _ in range(n)]
        self.reference = [TickSeries(3) for _ in range(n)]
        self.centre = [TickSeries(6) for _ in range(n)]
        self.law_state = [TickSeries() for _ in range(n)]
        self.holding = [TickSeries(1) for _ in range(n)]
        self.neighbours = [TickSeries(n * PUBLISHED) for _ in range(n)]
        self.sent = RecordedRows(3)
        self.received = RecordedRows(5)
        self.contacts = RecordedRows(5)
        self.events = RecordedRows(9)
        self.lost: set[str] = set()
        self._lost_at: tuple[int, ...] = (-1, 0)
        self._time_line = RunTimeLine(bag, vehicle_ids, period_s, most_ticks)
        self._read(bag)

    def _read(self, bag: Bag) -> None:
        """Take every message that arrays are made of."""
        takings = self._takings()
        for topic, batches, count in bag.columns(takings.keys() & bag.topics.keys()):
            left_out = count - sum(_take(takings[topic], batch) for batch in batches)
            if left_out:
                self.left_out[topic] += left_out

    def _takings(self) -> dict[str, _Taking]:
        """Return the handlers of messages, by topic."""
        takings = {
            STATUS_TOPIC: _Taking(_all, self._take_status, 0),
            _EVENTS_TOPIC: _Taking(self._are_events_ours, self._take_events, 0),
        }
        for i, name in enumerate(self._ids):
            for topic, are_ours, take in (
                ("state", self._are_on_time, self._take_state),
                ("nav", self._have_known_tick, self._take_nav),
                ("cmd_wrench", self._have_known_stamp, self._take_wrench),
                ("cmd_vel", self._have_known_stamp, self._take_velocity_command),
                ("cmd_fins", self._have_known_stamp, self._take_fins),
                ("cmd_thrusters", self._have_known_stamp, self._take_forces),
                ("actuators", self._have_known_stamp, self._take_outputs),
                ("reference", self._have_known_stamp, self._take_reference),
                ("flocking_centre", self._have_known_tick, self._take_centre),
                ("control_status", self._have_known_tick, self._take_control_status),
                ("neighbours", self._are_neighbours_ours, self._take_neighbours),
                ("acoustic/tx", self._are_packets_ours, self._take_sent),
                ("acoustic/rx", self._are_receptions_ours, self._take_received),
            ):
                takings[f"/{name}/{topic}"] = _Taking(are_ours, take, i)
        return takings

    def _have_known_tick(self, _: int, batch: Batch) -> Flags:
        return self._time_line.has(batch.messages.tick)

    def _have_known_stamp(self, _: int, batch: Batch) -> Flags:
        return self._time_line.has(self._time_line.ticks(batch.messages.header.stamp))

    def _are_on_time(self, i: int, batch: Batch) -> Flags:
        """Return which states have a tick and a stamp on the run's time line."""
        ticks, stamp = batch.messages.tick, batch.messages.header.stamp
        are_known = self._time_line.has(ticks)
        late_ns = self._time_line.lateness_ns(np.where(are_known, ticks, 0), stamp)
        are_of_old_run = (ticks == 0) & (nanoseconds(stamp) == 0)
        are_off = are_known & (np.abs(late_ns) > 0.5e9 * self._period_s) & ~are_of_old_run
        for k in np.flatnonzero(are_off):
            time_ns, place = batch.order[k].tolist()
            if (time_ns, place) < self._off_time_at:
                self._off_time_at = time_ns, place
                self.off_time = (
                    f"/{self._ids[i]}/state of tick {ticks[k]} is stamped "
                    f"{abs(late_ns[k]) * 1e-9:.3f} s {'late' if late_ns[k] > 0 else 'early'}"
                )
        return are_known & ~are_off

    def _are_neighbours_ours(self, i: int, batch: Batch) -> Flags:
        flags = self._have_known_tick(i, batch)
        for estimate in batch.messages.neighbours:
            flags &= self._are_vehicles(estimate.address)
        return flags

    def _are_packets_ours(self, _: int, batch: Batch) -> Flags:
        flags = _all(0, batch)
        for packet in batch.messages.packets:
            flags &= self._time_line.has(packet.tick) & self._are_vehicles(packet.source)
        return flags

    def _are_receptions_ours(self, i: int, batch: Batch) -> Flags:
        flags = self._have_known_tick(i, batch)
        for reception in batch.messages.receptions:
            flags &= self._are_vehicles(reception.packet.source)
        return flags

    def _are_events_ours(self, i: int, batch: Batch) -> Flags:
        flags = self._have_known_tick(i, batch)
        for event in batch.messages.events:
            is_for_one = self._are_vehicles(event.destination)
            flags &= self._are_vehicles(event.source) & (is_for_one | (event.destination == 0))
            flags &= np.isin(event.outcome, list(Outcome))
        return flags

    def _are_vehicles(self, addresses: Any) -> Flags:
        flags: Flags = (addresses >= 1) & (addresses <= len(self._ids))
        return flags

    def _take_state(self, i: int, batch: Batch) -> None:
        state = batch.messages
        q = state.pose.orientation
        attitude = (q.w, q.x, q.y, q.z)
        values = _rows(
            *_xyz(state.pose.position), *attitude, *_xyz(state.twist.linear), *_xyz(state.twist.angular)
        )
        self.state[i].add(batch.order, state.tick, values)

    def _take_nav(self, i: int, batch: Batch) -> None:
        nav = batch.messages
        self.nav[i].add(batch.order, nav.tick, _rows(*_xyz(nav.pose.position), nav.position_sd_m))

    def _take_wrench(self, i: int, batch: Batch) -> None:
        wrench = batch.messages.wrench
        self._take_stamped(self.command[i], batch, _rows(*_xyz(wrench.force), *_xyz(wrench.torque)))

    def _take_velocity_command(self, i: int, batch: Batch) -> None:
        twist = batch.messages.twist
        self._take_stamped(self.command[i], batch, _rows(*_xyz(twist.linear), *_xyz(twist.angular)))

    def _take_fins(self, i: int, batch: Batch) -> None:
        fins = batch.messages
        self._take_stamped(
            self.command[i], batch, _rows(fins.rudder_rad, fins.stern_plane_rad, fins.propeller_rpm)
        )

    def _take_forces(self, i: int, batch: Batch) -> None:
        self._take_stamped(self.command[i], batch, batch.messages.forces_n.copy())

    def _take_outputs(self, i: int, batch: Batch) -> None:
        self._take_stamped(self.actuator_output[i], batch, batch.messages.outputs.copy())

    def _take_reference(self, i: int, batch: Batch) -> None:
        self._take_stamped(self.reference[i], batch, _rows(*_xyz(batch.messages.twist.linear)))

    def _take_stamped(self, series: TickSeries, batch: Batch, values: FloatArray) -> None:
        series.add(batch.order, self._time_line.ticks(batch.messages.header.stamp), values)

    def _take_centre(self, i: int, batch: Batch) -> None:
        centre = batch.messages
        values = _rows(*_xyz(centre.position), *_xyz(centre.velocity))
        self.centre[i].add(batch.order, centre.tick, values)

    def _take_control_status(self, i: int, batch: Batch) -> None:
        status = batch.messages
        if status.law_state.shape[1]:
            self.law_state[i].add(batch.order, status.tick, status.law_state.copy())
        if status.holding:
            causes = np.full((len(status), 1), float(cause_number(status.holding)))
            self.holding[i].add(batch.order, status.tick, causes)

    def _take_neighbours(self, i: int, batch: Batch) -> None:
        message = batch.messages
        table = np.full((len(message), len(self._ids), PUBLISHED), np.nan)
        messages = np.arange(len(message))
        for estimate in message.neighbours:
            neighbours = estimate.address.astype(np.int64) - 1
            moments = _rows(*_xyz(estimate.position), *_xyz(estimate.velocity))
            table[messages, neighbours, POSITION:COVARIANCE] = moments
            table[messages, neighbours, COVARIANCE:AGE] = estimate.covariance
            table[messages, neighbours, AGE] = estimate.age_s
            table[messages, neighbours, SONAR_AGE] = estimate.sonar_age_s
        self.neighbours[i].add(batch.order, message.tick, table.reshape(len(message), -1))

    def _take_sent(self, _: int, batch: Batch) -> None:
        for packet in batch.messages.packets:
            self.sent.add(batch.order, _rows(packet.tick, packet.source, packet.sequence))

    def _take_received(self, i: int, batch: Batch) -> None:
        tick = batch.messages.tick
        for each in batch.messages.receptions:
            packet = each.packet
            self.received.add(batch.order, _rows(tick, packet.source, i + 1, packet.sequence, _delay_s(each)))
        for c in batch.messages.contacts:
            self.contacts.add(batch.order, _rows(tick, i + 1, c.range_m, c.bearing_rad, c.elevation_rad))

    def _take_events(self, _: int, batch: Batch) -> None:
        for e in batch.messages.events:
            keys = (e.outcome, e.source, e.destination, e.sequence, e.size_bytes)
            self.events.add(batch.order, _rows(batch.messages.tick, *keys, *self._event_times_s(e), e.snr_db))

    def _event_times_s(self, e: Columns) -> tuple[FloatArray, FloatArray]:
        if hasattr(e, "start_s"):  # a bag from before the times were stamps
            return e.start_s, e.end_s
        return self._time_line.scenario_s(e.start), self._time_line.scenario_s(e.end)

    def _take_status(self, _: int, batch: Batch) -> None:
        latest = max(map(tuple, batch.order.tolist()))
        if latest > self._lost_at:  # the clock repeats a loss: a loss that the next status lacks is forged
            self.lost, self._lost_at = set(batch.messages.lost_vehicles), latest


def _take(taking: _Taking, batch: Batch) -> int:
    """Take the messages of this run; return their number."""
    ours = taking.are_ours(taking.i, batch)
    if not ours.all():
        batch = batch.only(ours)
    if len(batch.messages):
        taking.take(taking.i, batch)
    return len(batch.messages)


def _all(_: int, batch: Batch) -> Flags:
    return np.ones(len(batch.messages), np.bool_)


def _delay_s(reception: Columns) -> FloatArray:
    """Return the time from the start of a transmission to the end of its reception (s)."""
    delay_s: FloatArray
    if hasattr(reception, "sent_s"):  # a bag from before the times were stamps
        delay_s = reception.arrival_s - reception.sent_s
    else:
        delay_s = seconds(nanoseconds(reception.arrival) - nanoseconds(reception.sent))
    return delay_s


def _xyz(vector: Columns) -> tuple[FloatArray, ...]:
    """Return the components of Points or Vector3s."""
    return vector.x, vector.y, vector.z


def _rows(first: FloatArray, *others: Any) -> FloatArray:
    """Return numbers as columns side by side; a single number becomes a constant column."""
    rows = np.empty((len(first), 1 + len(others)))
    for k, column in enumerate((first, *others)):
        rows[:, k] = column
    return rows
