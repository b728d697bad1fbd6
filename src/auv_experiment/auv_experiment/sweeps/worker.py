"""The work of a sweep's worker: it flies one run at a time and returns the result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from auv_core.machine.failure import Failure
from auv_experiment.inprocess.evaluated_run import run_evaluated
from auv_experiment.run_key import source_version
from auv_experiment.scenario.loading import scenario_from_json

Scalar = bool | int | float | str | None

NO_RESULTS = {"scenario", "seed", "mode", "real_time_factor", "lost_vehicles"}
"""Metrics that describe the run or its speed, or are constant in one process."""


class SourceMismatchError(RuntimeError):
    """Raised if a worker has other source or packages than the sweep; the message is one line."""


@dataclass(frozen=True)
class Finished:
    """
    The result of a run.

    Attributes
    ----------
    metrics : dict
        Every metric with a single value; empty if the run failed.
    error, traceback : str
        The failure, in one line and in full; empty if there was none.
    is_lasting : bool
        Whether another attempt would give the same result.
    wall_s, cpu_s : float or None
        Wall and processor time of the run (s).

    """

    metrics: dict[str, Scalar]
    error: str = ""
    traceback: str = ""
    is_lasting: bool = True
    wall_s: float | None = None
    cpu_s: float | None = None


def fly_run(scenario_json: str, source: str) -> Finished:
    """
    Fly a run and return its result; a failure is a result, too.

    Parameters
    ----------
    scenario_json : str
        Resolved scenario.
    source : str
        `source_version` of the sweep.

    Raises
    ------
    SourceMismatchError
        If this process has another source.

    """
    if source_version() != source:
        raise SourceMismatchError(
            f"a worker has other source or packages ({source_version()}) than this machine ({source}); "
            "allowed: the same checkout, Python and packages everywhere"
        )
    try:
        run = run_evaluated(scenario_from_json(scenario_json))
    except Exception as error:
        failure = Failure.of(error)
        is_lasting = not isinstance(error, OSError | MemoryError)
        return Finished({}, failure.line, failure.traceback, is_lasting)
    return Finished(_scalars(run.metrics), wall_s=run.wall_s, cpu_s=run.cpu_s)


def _scalars(metrics: dict[str, Any]) -> dict[str, Scalar]:
    """Return the metrics with a single value, without `NO_RESULTS`."""
    return {
        key: value
        for key, value in metrics.items()
        if key not in NO_RESULTS and (value is None or isinstance(value, bool | int | float | str))
    }
