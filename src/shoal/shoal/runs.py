"""Runs in one process: one, or many."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from auv_core.cli.tally import Tally
from auv_core.machine.processors import processor_count
from auv_core.params import ConfigError
from auv_experiment.inprocess.evaluated_run import run_evaluated
from auv_experiment.results import make_folder
from auv_experiment.scenario import schema
from auv_experiment.sweeps.local import fly_here
from auv_experiment.sweeps.plan import plan_runs
from auv_experiment.sweeps.runner import run_sweep
from auv_experiment.sweeps.study import Study, load_study, study_from_plain
from auv_experiment.sweeps.table import PREFIX, read_table
from shoal.plain import plain
from shoal.result import Result
from shoal.scenario import Scenario, load, resolve
from shoal.summaries import DRAW, GRID

if TYPE_CHECKING:
    import pandas as pd


def run(
    scenario: Scenario | schema.Scenario | str | Path,
    *,
    seed: int | None = None,
    duration_s: float | None = None,
    on_progress: Callable[[float], None] | None = None,
) -> Result:
    """
    Fly a scenario in this process, without ROS; equal calls give equal numbers.

    Parameters
    ----------
    scenario : Scenario, str or Path
        What to fly: a scenario from `load`, or an argument of `load`.
    seed : int, optional
        Seed of every random number; by default the scenario's.
    duration_s : float, optional
        Length of the flight (s); by default the scenario's.
    on_progress : callable, optional
        Called from time to time with the scenario time reached (s).

    Returns
    -------
    result : Result
        Metrics, recording and figures of the run.

    Raises
    ------
    ConfigError
        If the scenario is not allowed, or will not fit into memory; one line.
    DivergedError
        If a motion has no finite solution.

    Examples
    --------
    >>> import shoal
    >>> result = shoal.run("ch5_one_leader", seed=3, duration_s=1.0)
    >>> result.recording.n_vehicles
    4

    """
    resolved = resolve(scenario, seed=seed, duration_s=duration_s)
    flown = run_evaluated(resolved, on_progress=on_progress)
    return Result(resolved, flown.recording, mode="inprocess", metrics=flown.metrics)


def sweep(
    what: Scenario | str | Path,
    *,
    grid: Mapping[str, Iterable[Any]] | None = None,
    seeds: Iterable[int] | None = None,
    duration_s: float | None = None,
    workers: int | None = None,
    folder: str | Path | None = None,
) -> pd.DataFrame:
    """
    Fly a scenario with many seeds and values, or a study, on the processors of this machine.

    Parameters
    ----------
    what : Scenario, str or Path
        With `grid` or `seeds` a scenario, as `run` takes it; without them the name of a study or its file.
    grid : mapping, optional
        Values by dotted key of the scenario; every combination is flown.
    seeds : iterable of int, optional
        Seeds of every combination; by default 1 only.
    duration_s : float, optional
        Length of every flight (s).
    workers : int, optional
        Number of processes; by default one per processor.
    folder : str or Path, optional
        Folder that keeps finished runs and the table, so that the same call continues an interrupted sweep.

    Returns
    -------
    table : pandas.DataFrame
        One row for each run: ``scenario.<key>``, ``seed``, ``status``, ``error``, and every metric; of a
        study with a sample also ``draw``, the number of the draw. `summarise` gives means and their
        intervals.

    Raises
    ------
    ConfigError
        If a run is not allowed; then nothing has been flown.

    Examples
    --------
    >>> import shoal
    >>> loss = "acoustics.outage.params.loss_prob"
    >>> table = shoal.sweep(
    ...     "flock_acoustic", grid={loss: [0.0, 0.5]}, seeds=range(2), duration_s=2.0, workers=1
    ... )
    >>> len(table)
    4

    """
    import pandas as pd

    count = processor_count() if workers is None else workers
    if count < 1:
        raise ConfigError(f"workers: {count} is not allowed; allowed: a whole number from 1")
    with tempfile.TemporaryDirectory(prefix="shoal-") as passing:
        place = Path(passing if folder is None else folder)
        make_folder(place)
        if grid is None and seeds is None:
            if isinstance(what, Scenario):
                raise ConfigError("seeds: missing; allowed: seeds, or a grid, to fly a scenario with")
            study = load_study(str(what))
            study = study if duration_s is None else replace(study, duration_s=duration_s)
        else:
            study = _study_of(
                what, grid or {}, [1] if seeds is None else list(seeds), duration_s, Path(passing)
            )
        runs = plan_runs(study)
        with Tally("runs", io.StringIO()) as tally:
            run_sweep(study, runs, place, partial(fly_here, n_workers=count), tally=tally)
        found = read_table(place)
        table = pd.DataFrame(found.columns).drop(columns=["key"])
        if study.sample:
            table.insert(0, DRAW, [found.draw_of(row) for row in range(found.n_runs)])
        table.attrs[GRID] = [PREFIX + path for path in study.grid or {}]
        return table


def _study_of(
    what: Scenario | str | Path,
    grid: Mapping[str, Iterable[Any]],
    seeds: list[int],
    duration_s: float | None,
    folder: Path,
) -> Study:
    """Return the study that flies a scenario over a grid; the scenario's file is written into `folder`."""
    scenario = what if isinstance(what, Scenario) else load(what)
    path = scenario.save(folder / "scenario.yaml")
    raw: dict[str, Any] = {
        "schema": 1,
        "name": scenario["name"],
        "title": scenario["title"],
        "scenario": str(path),
        "seeds": seeds,
    }
    if grid:
        raw["grid"] = {key: list(values) for key, values in grid.items()}
    if duration_s is not None:
        raw["duration_s"] = duration_s
    return study_from_plain(plain(raw))
