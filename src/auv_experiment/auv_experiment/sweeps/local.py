"""Runs in processes of this machine; no process listens, so no other program can send work to them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

from auv_core.machine.failure import Failure
from auv_core.machine.workers import Advance, spread
from auv_experiment.inprocess.evaluated_run import load_source
from auv_experiment.run_key import source_version
from auv_experiment.sweeps.patience import Patience
from auv_experiment.sweeps.plan import PlannedRun
from auv_experiment.sweeps.worker import Finished, fly_run


def fly_here(
    runs: Sequence[PlannedRun],
    on_result: Callable[[PlannedRun, Finished], None],
    on_message: Callable[[str], None],
    *,
    n_workers: int,
    patience: Patience | None = None,
) -> None:
    """
    Fly runs in processes of this machine, in their order as workers become free.

    Parameters
    ----------
    runs : sequence of PlannedRun
        Runs with different keys.
    on_result : callable
        Receives each run and its outcome when it ends.
    on_message : callable
        Receives one line if a worker is replaced.
    n_workers : int
        Number of processes.
    patience : Patience, optional
        Limits the duration of a run; by default there is no limit.

    Raises
    ------
    WorkersError
        If no worker process can be started.

    """
    load_source()
    calls = [partial(_fly, run.scenario_json, source_version()) for run in runs]

    def note(index: int, result: Finished | Failure) -> None:
        if isinstance(result, Failure):
            result = Finished({}, result.line, result.traceback, is_lasting=False)
        on_result(runs[index], result)

    def limit_s(index: int) -> float:
        return math.inf if patience is None else patience.limit_s(runs[index])

    spread(calls, n_workers, on_result=note, on_message=on_message, limit_s=limit_s)


def _fly(scenario_json: str, source: str, advance: Advance) -> Finished:
    del advance
    return fly_run(scenario_json, source)
