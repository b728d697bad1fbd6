"""From a study to its runs: every point and seed resolved and checked before anything is flown."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from auv_core.params import ConfigError, shown
from auv_experiment.inprocess.evaluated_run import effort
from auv_experiment.metrics.descriptions import MEANINGS, OF_LAWS
from auv_experiment.metrics.own import own_files_of_metrics
from auv_experiment.run_key import run_key, source_version
from auv_experiment.scenario.loading import load_for_seeds, scenario_to_json
from auv_experiment.sweeps.study import Sample, Study, value_text
from auv_experiment.sweeps.worker import NO_RESULTS, fly_run

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

_REHEARSED_TICKS = 3


@dataclass(frozen=True)
class PlannedRun:
    """
    One run of a study.

    Attributes
    ----------
    index : int
        Position in the study, and row in the table.
    parameters : dict
        Values of the varied parameters, without the seed, by dotted path.
    seed : int
        Seed of the run.
    key : str
        Identifies everything that determines its numbers.
    effort : float
        Expected work, in evaluations of a law.
    scenario_json : str
        The resolved scenario.

    """

    index: int
    parameters: dict[str, Any]
    seed: int
    key: str
    effort: float
    scenario_json: str


def plan_runs(study: Study) -> list[PlannedRun]:
    """
    Return the runs of a study: the points in their order, each with all seeds.

    Raises
    ------
    ConfigError
        With one line, if the scenario of a point is not allowed (the line names the point), or if no run has
        a metric.

    """
    own_files_of_metrics()
    runs: list[PlannedRun] = []
    for parameters in points(study):
        for scenario in _scenarios(study, parameters):
            if not runs:
                _check_metrics(study, scenario)
            text = scenario_to_json(scenario)
            run = PlannedRun(len(runs), parameters, scenario.seed, run_key(scenario), effort(scenario), text)
            runs.append(run)
    return runs


def points(study: Study) -> Iterator[dict[str, Any]]:
    """Yield the parameters of every point: the grid as nested loops, and in each of them the sample."""
    grid = study.grid or {}
    drawn = list(_drawn(study.sample)) if study.sample else [{}]
    for values in itertools.product(*grid.values()):
        for sampled in drawn:
            yield {**dict(zip(grid, values, strict=True)), **sampled}


def override_texts(study: Study, parameters: dict[str, Any]) -> tuple[str, ...]:
    """Return the `--set` overrides of a point."""
    return tuple(f"{path}={value_text(value)}" for path, value in {**study.fixed, **parameters}.items())


def _drawn(sample: Sample) -> Iterator[dict[str, Any]]:
    """Yield the points of a Latin hypercube: one in each of `count` equal shares of every distribution."""
    rng = np.random.default_rng(np.random.SeedSequence(sample.seed))
    columns = {
        path: (rng.permutation(sample.count) + rng.random(sample.count)) / sample.count
        for path in sample.parameters
    }
    for index in range(sample.count):
        yield {path: d.at(float(columns[path][index])) for path, d in sample.parameters.items()}


def _scenarios(study: Study, parameters: dict[str, Any]) -> Iterator[Scenario]:
    try:
        yield from load_for_seeds(
            study.scenario, overrides=override_texts(study, parameters), seeds=study.seeds
        )
    except ConfigError as error:
        where = ", ".join(f"{path} = {value_text(value)}" for path, value in parameters.items())
        raise ConfigError(f"study{f' at {where}' if where else ''}: {error}") from None


def _check_metrics(study: Study, scenario: Scenario) -> None:
    """Refuse metrics that runs do not have; a run of a few ticks shows which they have."""
    of_every_run = set(MEANINGS) - set(OF_LAWS) - NO_RESULTS
    if of_every_run.issuperset(study.metrics):
        return
    rehearsal = replace(scenario, duration_s=min(scenario.ticks, _REHEARSED_TICKS) * scenario.period_s)
    rehearsed = fly_run(scenario_to_json(rehearsal), source_version())
    for name in study.metrics:
        if not rehearsed.error and name not in rehearsed.metrics:
            known = ", ".join(sorted(rehearsed.metrics))
            raise ConfigError(f"study.metrics: {shown(name)} is not allowed; allowed: {known}")
