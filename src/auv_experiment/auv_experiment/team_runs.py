"""A run by teams: each as a run of its own, for metrics and figures that look at one task."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from auv_experiment.recording import IntArray, Recording
from auv_experiment.recording_shapes import NEIGHBOURS, shapes_of
from auv_experiment.scenario.teams import has_one_agent, of_team, teams

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

_ROWS_OF = {"delay_s": "received", "contact_values": "contacts", "event_values": "events"}
_ADDRESSES = {"sent": (1,), "received": (1, 2), "contacts": (1,), "events": (2, 3)}
_BROADCAST = 0


class TeamRun(NamedTuple):
    """What one team did, and its scenario; addresses are those within the team."""

    recording: Recording
    scenario: Scenario


def team_runs(recording: Recording, scenario: Scenario) -> list[TeamRun]:
    """Return the run of each team, in the order of their first vehicles; the run itself if there is one."""
    if has_one_agent(scenario):
        return [TeamRun(recording, scenario)]
    return [
        TeamRun(_of_vehicles(recording, indices), of_team(scenario, indices)) for indices in teams(scenario)
    ]


def flock_run(runs: Sequence[TeamRun]) -> TeamRun | None:
    """Return the run of the first flock, None without one."""
    return next((run for run in runs if run.scenario.agent.flocking is not None), None)


def _of_vehicles(recording: Recording, indices: Sequence[int]) -> Recording:
    """Return what some vehicles did, with the packets among them, without their neighbour estimates."""
    count = recording.n_vehicles
    if len(indices) == count:
        return recording
    arrays: dict[str, Any] = {}
    more = shapes_of(len(recording.t_s), count + 1)
    for name, shape in shapes_of(len(recording.t_s), count).items():
        values = getattr(recording, name)
        for axis, (size, other) in enumerate(zip(shape, more[name], strict=True)):
            if size != other:
                values = values.take(indices, axis=axis)
        arrays[name] = values[:0] if name in NEIGHBOURS else values
    rank_of = np.full(count + 1, -1, dtype=np.int64)
    rank_of[_BROADCAST] = _BROADCAST
    rank_of[np.array(indices) + 1] = np.arange(1, len(indices) + 1)
    kept: dict[str, Any] = {}
    for name, columns in _ADDRESSES.items():
        arrays[name], kept[name] = _among(arrays[name], columns, rank_of)
    for name, rows in _ROWS_OF.items():
        arrays[name] = arrays[name][kept[rows]]
    return Recording(vehicle_ids=tuple(recording.vehicle_ids[index] for index in indices), **arrays)


def _among(rows: IntArray, columns: tuple[int, ...], rank_of: IntArray) -> tuple[IntArray, Any]:
    """Return the rows whose addresses all have a rank, with these ranks, and which rows they are."""
    ranks = rank_of[rows[:, columns]]
    kept = (ranks >= 0).all(axis=1)
    found = rows[kept]
    found[:, columns] = ranks[kept]
    return found, kept
