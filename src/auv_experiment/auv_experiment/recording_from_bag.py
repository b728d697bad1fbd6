"""Turn a recorded bag into the arrays of a run."""

from __future__ import annotations

from collections.abc import Callable
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from auv_bag.bag import Bag
from auv_bag.writer import BagError
from auv_core.freshness import age_limit_s
from auv_experiment.recording import Recording, law_states
from auv_experiment.run_messages import RunMessages
from auv_flocking.holding import STALE_COMMAND, cause_number
from auv_flocking.neighbours.estimates import AGE, COVARIANCE, POSITION, PUBLISHED, SONAR_AGE, VELOCITY

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

FloatArray = NDArray[np.float64]


def read_recording(
    bag_dir: Path, scenario: Scenario, tell: Callable[[str], None] = lambda _: None
) -> Recording:
    """Read the arrays of a run from its bag.

    Ticks that a bag lacks (a real-time run may miss some) hold the values of the tick before; commands no
    longer than a vehicle acts on them, then it rests. A lost vehicle's commands and estimates are NaN from
    its loss on. Rows of `sent` are in the order of tick and source, those of `received` of tick, destination
    and arrival, those of `events` as the medium wrote them.

    Parameters
    ----------
    bag_dir
        Bag folder or results folder.
    scenario
        The scenario that was run: names and order of the vehicles, control period, length.
    tell
        Gets a line about what is left out: messages that cannot be read, or that name ticks or vehicles which
        the run does not have.

    Returns
    -------
    Recording
        Of as many ticks as every vehicle has a recorded state for, at most those of the scenario.

    Raises
    ------
    BagError
        If the bag cannot be read or holds no state of some vehicle.
    """
    messages = RunMessages([vehicle.id for vehicle in scenario.vehicles], scenario.period_s, scenario.ticks)
    bag = Bag(Path(bag_dir))
    messages.read(bag)
    if messages.left_out:
        counts = ", ".join(f"{count} of {topic}" for topic, count in sorted(messages.left_out.items()))
        off_time = f"; {messages.off_time}" if messages.off_time else ""
        tell(f"messages left out, which are not of this run: {counts}{off_time}")
    return _Arrays(messages, scenario).recording(bag.path)


class _Arrays:
    """Makes the arrays of a run from its messages."""

    def __init__(self, messages: RunMessages, scenario: Scenario) -> None:
        self._messages = messages
        self._ids = [vehicle.id for vehicle in scenario.vehicles]
        self._most_ticks = scenario.ticks
        self._period_s = scenario.period_s
        limit_s = age_limit_s(scenario.command_max_age_s, scenario.period_s)
        self._command_max_age_ticks = limit_s / scenario.period_s

    def recording(self, path: Path) -> Recording:
        """Return the arrays; `path` is that of the bag, for the error message."""
        missing = [
            name for name, series in zip(self._ids, self._messages.state, strict=True) if not series.values
        ]
        if missing:
            raise BagError(f"{path} holds no state of {', '.join(missing)}")
        n_ticks = min(self._most_ticks, *(max(series.values) for series in self._messages.state))
        t_s: FloatArray = np.arange(n_ticks + 1, dtype=np.float64) * self._period_s
        recording = Recording.empty(self._ids, t_s)
        for i, name in enumerate(self._ids):
            self._add_truth(recording, i)
            lost = name in self._messages.lost and self._falls_silent(i, n_ticks)
            self._add_decisions(recording, i, lost=lost)
        self._add_laws(recording)
        self._add_packets(recording)
        self._add_sound(recording)
        return recording

    def _falls_silent(self, i: int, n_ticks: int) -> bool:
        """Return whether vehicle i gets no command any more before the end: one that does is not lost."""
        return max(self._messages.command[i].values, default=-1) < n_ticks - 1

    def _add_truth(self, recording: Recording, i: int) -> None:
        """Fill in the states of vehicle i."""
        state = self._messages.state[i].table(recording.n_ticks + 1, hold_to_end=True)
        recording.position_ned_m[:, i] = state[:, :3]
        recording.attitude_quat_wxyz[:, i] = state[:, 3:7]
        recording.velocity_body[:, i] = state[:, 7:]
        nav = self._messages.nav[i].table(recording.n_ticks, hold_to_end=True)
        recording.nav_position_ned_m[:, i] = nav[:, :3]
        recording.nav_position_sd_m[:, i] = nav[:, 3]

    def _add_decisions(self, recording: Recording, i: int, *, lost: bool) -> None:
        """Fill in what the computer of vehicle i made, up to its loss."""
        k, n = recording.n_ticks, recording.n_vehicles
        recording.command[:, i] = self._messages.command[i].table(k, hold_to_end=not lost)
        recording.reference_velocity_ned_mps[:, i] = self._messages.reference[i].table(
            k, hold_to_end=not lost
        )
        centre = self._messages.centre[i].table(k, hold_to_end=not lost)
        recording.centre_ned_m[:, i] = centre[:, :3]
        recording.centre_velocity_ned_mps[:, i] = centre[:, 3:]
        neighbours = self._messages.neighbours[i].table(k, hold_to_end=not lost).reshape(k, n, PUBLISHED)
        recording.neighbour_position_ned_m[:, i] = neighbours[..., POSITION:VELOCITY]
        recording.neighbour_velocity_ned_mps[:, i] = neighbours[..., VELOCITY:COVARIANCE]
        recording.neighbour_covariance[:, i] = neighbours[..., COVARIANCE:AGE].reshape(k, n, 6, 6)
        recording.neighbour_age_s[:, i] = neighbours[..., AGE]
        recording.neighbour_sonar_age_s[:, i] = neighbours[..., SONAR_AGE]
        if not lost:
            is_resting = self._messages.command[i].ages(k) > self._command_max_age_ticks
            recording.command[is_resting, i] = 0.0
            recording.holding[is_resting, i] = cause_number(STALE_COMMAND)
        if lost:
            recording.lost_at_s[i] = (max(self._messages.command[i].values, default=-1) + 1) * self._period_s

    def _add_laws(self, recording: Recording) -> None:
        """Fill in what the laws remembered and when agents held the safe command."""
        k, n = recording.n_ticks, recording.n_vehicles
        recording.law_state = law_states(self._held(self._messages.law_state, k), k, n)
        for (tick, i), cause in self._messages.holding.items():
            if tick < k:
                recording.holding[tick, i] = cause

    def _held(
        self, states: dict[tuple[int, int], list[float]], n_ticks: int
    ) -> dict[tuple[int, int], list[float]]:
        """Return the states with those of the tick before in missed ticks, to the vehicle's last command."""
        held = dict(states)
        for i, commands in enumerate(self._messages.command):
            for tick in range(1, min(n_ticks, max(commands.values, default=-1) + 1)):
                if (tick, i) not in held and (tick - 1, i) in held:
                    held[tick, i] = held[tick - 1, i]
        return held

    def _add_packets(self, recording: Recording) -> None:
        """Fill in the packets of the ticks that are kept: by tick and vehicle, then as they came."""
        sent = [row for row in self._messages.sent if row[0] < recording.n_ticks]
        sent.sort(key=itemgetter(0, 1))
        received = [row for row in self._messages.received if row[0] < recording.n_ticks]
        received.sort(key=itemgetter(0, 2))
        recording.sent = np.array(sent, dtype=np.int64).reshape(-1, 3)
        recording.received = np.array([row[:4] for row in received], dtype=np.int64).reshape(-1, 4)
        recording.delay_s = np.array([row[4] for row in received], dtype=np.float64)

    def _add_sound(self, recording: Recording) -> None:
        """Fill in the sonar contacts and the acoustic log of the ticks that are kept."""
        contacts = [row for row in self._messages.contacts if row[0] < recording.n_ticks]
        contacts.sort(key=itemgetter(0, 1))
        recording.contacts = np.array([row[:2] for row in contacts], dtype=np.int64).reshape(-1, 2)
        recording.contact_values = np.array([row[2:] for row in contacts], dtype=np.float64).reshape(-1, 3)
        events = [row for row in self._messages.events if row[0] < recording.n_ticks]
        recording.events = np.array([row[:6] for row in events], dtype=np.int64).reshape(-1, 6)
        recording.event_values = np.array([row[6:] for row in events], dtype=np.float64).reshape(-1, 3)
