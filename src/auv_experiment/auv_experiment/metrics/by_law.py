"""Metrics by the law of a run: each family of laws has its own numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from auv_experiment.metrics.consensus_bound import flock_metrics
from auv_experiment.metrics.courses.course import course_metrics
from auv_experiment.metrics.courses.effort import fin_effort_metrics
from auv_experiment.metrics.courses.fleet import fleet_metrics
from auv_experiment.metrics.formations.errors import formation_metrics
from auv_experiment.metrics.lyapunov import lyapunov_metrics
from auv_experiment.metrics.path import path_metrics, position_error_ned_m
from auv_experiment.metrics.region import region_metrics
from auv_experiment.recording import Recording
from auv_experiment.team_runs import TeamRun

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


def law_metrics(runs: Sequence[TeamRun]) -> dict[str, Any]:
    """
    Return the metrics of the kind of law of each team, and whether its Lyapunov candidates decrease.

    A metric that several teams have is that of the first of them.

    `Scenario.readings` gives one metric each, ``<axis>_err_<time>_m``: path minus position of the first
    vehicle along one NED axis at one instant (m), at the record nearest to it.

    See `path_metrics`, `formation_metrics`, `region_metrics`, `course_metrics`, `fin_effort_metrics` and
    `flock_metrics` for their definitions.
    """
    metrics: dict[str, Any] = {}
    for run in runs:
        metrics |= {key: value for key, value in _of_team(*run).items() if key not in metrics}
    return metrics


def _of_team(recording: Recording, scenario: Scenario) -> dict[str, Any]:
    if recording.n_ticks == 0:
        return {}
    return _family_metrics(recording, scenario) | fin_effort_metrics(recording, scenario)


def _family_metrics(recording: Recording, scenario: Scenario) -> dict[str, Any]:
    if scenario.follows == "velocity":
        return flock_metrics(recording, scenario)
    if scenario.agent.fleet is not None:
        return fleet_metrics(recording, scenario)
    if scenario.follows == "course":
        return course_metrics(recording, scenario)
    if scenario.follows == "region":
        metrics = region_metrics(recording, scenario)
    else:
        metrics = _readings(recording, scenario) | path_metrics(recording, scenario)
    if scenario.agent.controller.kind == "adaptive":
        metrics |= formation_metrics(recording, scenario)
    return metrics | lyapunov_metrics(recording, scenario)


def _readings(recording: Recording, scenario: Scenario) -> dict[str, float | None]:
    error_m = position_error_ned_m(recording, scenario)[:, 0]
    readings: dict[str, float | None] = {}
    for reading in scenario.readings:
        row = round(reading.time_s / scenario.period_s)
        exists = row <= recording.n_ticks
        readings[reading.key] = float(error_m[row, "xyz".index(reading.axis)]) if exists else None
    return readings
