"""Conversion of a bag to the arrays of a run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from auv_bag.bag import Bag
from auv_bag.writer import BagError
from auv_core.freshness import age_limit_s
from auv_experiment.actuator_rows import ActuatorRows
from auv_experiment.recording import Recording
from auv_experiment.run_messages import RunMessages
from auv_experiment.tick_series import FloatArray
from auv_flocking.holding import STALE_COMMAND, cause_number
from auv_flocking.neighbours.estimates import AGE, COVARIANCE, POSITION, PUBLISHED, SONAR_AGE, VELOCITY

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


def read_recording(
    bag_dir: Path, scenario: Scenario, tell: Callable[[str], None] = lambda _: None
) -> Recording:
    """Read the arrays of a run from its bag.

    Missing ticks of a bag (possible in real time) have the values of the tick before. Commands are repeated
    only as long as a vehicle acts on them; then it rests. A lost vehicle's commands and estimates are NaN
    after its loss. Rows of `sent` are sorted by tick and source, those of `received` by tick, destination and
    arrival; those of `events` have the order of the medium.

    Parameters
    ----------
    bag_dir
        Bag folder or results folder.
    scenario
        The scenario of the run: names and order of the vehicles, control period, length.
    tell
        Gets a line about omitted messages: unreadable ones, or ones with ticks or vehicles that the run does
        not have.

    Returns
    -------
    Recording
        It has as many ticks as there are recorded states of every vehicle, at most those of the scenario.

    Raises
    ------
    BagError
        If the bag cannot be read or has no state of a vehicle.
    """
    bag = Bag(Path(bag_dir))
    vehicle_ids = [vehicle.id for vehicle in scenario.vehicles]
    messages = RunMessages(bag, vehicle_ids, scenario.period_s, scenario.ticks)
    if messages.left_out:
        counts = ", ".join(f"{count} of {topic}" for topic, count in sorted(messages.left_out.items()))
        off_time = f"; {messages.off_time}" if messages.off_time else ""
        tell(f"messages left out, which are not of this run: {counts}{off_time}")
    return _Arrays(messages, scenario).recording(bag.path)


class _Arrays:
    """Converts messages to the arrays of a run."""

    def __init__(self, messages: RunMessages, scenario: Scenario) -> None:
        self._messages = messages
        self._ids = [vehicle.id for vehicle in scenario.vehicles]
        self._most_ticks = scenario.ticks
        self._period_s = scenario.period_s
        limit_s = age_limit_s(scenario.command_max_age_s, scenario.period_s)
        self._command_max_age_ticks = limit_s / scenario.period_s
        self._actuators = ActuatorRows([vehicle.model for vehicle in scenario.vehicles])

    def recording(self, path: Path) -> Recording:
        """Return the arrays; `path` is that of the bag, for the error message."""
        last_ticks = [series.last_tick for series in self._messages.state]
        missing = [name for name, last in zip(self._ids, last_ticks, strict=True) if last < 0]
        if missing:
            raise BagError(f"{path} holds no state of {', '.join(missing)}")
        n_ticks = min(self._most_ticks, *last_ticks)
        t_s: FloatArray = np.arange(n_ticks + 1, dtype=np.float64) * self._period_s
        recording = Recording.empty(self._ids, t_s)
        shape = (len(self._ids), self._actuators.most)
        commands, outputs = np.full((n_ticks, *shape), np.nan), np.full((n_ticks + 1, *shape), np.nan)
        for i, name in enumerate(self._ids):
            self._add_truth(recording, i)
            lost = name in self._messages.lost and self._falls_silent(i, n_ticks)
            self._add_decisions(recording, i, lost=lost)
            self._add_actuators(i, commands[:, i], outputs[:, i], lost=lost)
        self._actuators.put(recording, commands, outputs)
        self._add_laws(recording)
        self._add_packets(recording)
        self._add_sound(recording)
        return recording

    def _falls_silent(self, i: int, n_ticks: int) -> bool:
        """Return whether vehicle i gets no more commands before the end; otherwise it is not lost."""
        return self._messages.command[i].last_tick < n_ticks - 1

    def _add_truth(self, recording: Recording, i: int) -> None:
        """Fill in the states of vehicle i."""
        k = recording.n_ticks
        state = self._messages.state[i].table(k + 1, held_to=k)
        recording.position_ned_m[:, i] = state[:, :3]
        recording.attitude_quat_wxyz[:, i] = state[:, 3:7]
        recording.velocity_body[:, i] = state[:, 7:]
        nav = self._messages.nav[i].table(k, held_to=k)
        recording.nav_position_ned_m[:, i] = nav[:, :3]
        recording.nav_position_sd_m[:, i] = nav[:, 3]

    def _add_decisions(self, recording: Recording, i: int, *, lost: bool) -> None:
        """Fill in the outputs of vehicle i's computer, up to its loss."""
        k, n = recording.n_ticks, recording.n_vehicles
        held_to = None if lost else k
        if not self._actuators.counts[i]:
            recording.command[:, i] = self._commands(i, k, recording.command.shape[2], lost=lost)
        recording.reference_velocity_ned_mps[:, i] = self._messages.reference[i].table(k, held_to=held_to)
        centre = self._messages.centre[i].table(k, held_to=held_to)
        recording.centre_ned_m[:, i] = centre[:, :3]
        recording.centre_velocity_ned_mps[:, i] = centre[:, 3:]
        neighbours = self._messages.neighbours[i].table(k, held_to=held_to).reshape(k, n, PUBLISHED)
        recording.neighbour_position_ned_m[:, i] = neighbours[..., POSITION:VELOCITY]
        recording.neighbour_velocity_ned_mps[:, i] = neighbours[..., VELOCITY:COVARIANCE]
        recording.neighbour_covariance[:, i] = neighbours[..., COVARIANCE:AGE].reshape(k, n, 6, 6)
        recording.neighbour_age_s[:, i] = neighbours[..., AGE]
        recording.neighbour_sonar_age_s[:, i] = neighbours[..., SONAR_AGE]
        if not lost:
            recording.holding[self._is_resting(i, k), i] = cause_number(STALE_COMMAND)
        if lost:
            recording.lost_at_s[i] = (self._messages.command[i].last_tick + 1) * self._period_s

    def _add_actuators(self, i: int, commands: FloatArray, outputs: FloatArray, *, lost: bool) -> None:
        """Fill in what is asked of the actuators of vehicle i that have a state, and their outputs."""
        count, k = self._actuators.counts[i], len(commands)
        if count:
            commands[:, :count] = self._commands(i, k, count, lost=lost)
            reached = self._messages.actuator_output[i].table(k + 1, held_to=None if lost else k)
            outputs[:, :count] = _of_width(reached, count)

    def _commands(self, i: int, k: int, size: int, *, lost: bool) -> FloatArray:
        """Return the (k, size) numbers of vehicle i's commands: 0 while it rests, NaN after its loss."""
        commands = _of_width(self._messages.command[i].table(k, held_to=None if lost else k), size)
        if not lost:
            commands[self._is_resting(i, k)] = 0.0
        return commands

    def _is_resting(self, i: int, k: int) -> NDArray[np.bool_]:
        """Return in which ticks the actuators of vehicle i rest, since its last command is old."""
        resting: NDArray[np.bool_] = self._messages.command[i].ages(k) > self._command_max_age_ticks
        return resting

    def _add_laws(self, recording: Recording) -> None:
        """Fill in the laws' states, repeated up to the last command, and why agents held."""
        k, n = recording.n_ticks, recording.n_vehicles
        laws = self._messages.law_state
        recording.law_state = np.full((k, n, max(series.width for series in laws)), np.nan)
        for i, law in enumerate(laws):
            held_to = self._messages.command[i].last_tick
            recording.law_state[:, i, : law.width] = law.table(k, held_to=held_to)
            ticks, causes = self._messages.holding[i].latest
            kept = (ticks >= 0) & (ticks < k)
            recording.holding[ticks[kept], i] = causes[kept, 0]

    def _add_packets(self, recording: Recording) -> None:
        """Fill in the packets of the kept ticks: by tick and vehicle, then in the order of arrival."""
        sent = _before(recording.n_ticks, self._messages.sent.by(0, 1))
        received = _before(recording.n_ticks, self._messages.received.by(0, 2))
        recording.sent = sent.astype(np.int64)
        recording.received = received[:, :4].astype(np.int64)
        recording.delay_s = received[:, 4].copy()

    def _add_sound(self, recording: Recording) -> None:
        """Fill in the sonar contacts and the acoustic log of the kept ticks."""
        contacts = _before(recording.n_ticks, self._messages.contacts.by(0, 1))
        recording.contacts = contacts[:, :2].astype(np.int64)
        recording.contact_values = contacts[:, 2:].copy()
        events = _before(recording.n_ticks, self._messages.events.by())
        recording.events = events[:, :6].astype(np.int64)
        recording.event_values = events[:, 6:].copy()


def _before(tick: int, rows: FloatArray) -> FloatArray:
    """Return the rows of earlier ticks, which are in their first column."""
    return rows[rows[:, 0] < tick]


def _of_width(table: FloatArray, width: int) -> FloatArray:
    """Return a table with a number of columns; missing ones are NaN."""
    shown = np.full((len(table), width), np.nan)
    kept = min(width, table.shape[1])
    shown[:, :kept] = table[:, :kept]
    return shown
