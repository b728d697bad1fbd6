"""What a worker of a sweep does: one run at a time, its result told by what it returns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from auv_core.machine.failure import Failure
from auv_experiment.inprocess.evaluated_run import fly
from auv_experiment.run_key import source_version
from auv_experiment.scenario.loading import scenario_from_json

Scalar = bool | int | float | str | None

NO_RESULTS = {"scenario", "seed", "mode", "real_time_factor", "lost_vehicles"}
"""Metrics that say what was flown or how fast, or are always the same in one process."""


class SourceMismatchError(RuntimeError):
    """A worker has another source or other packages than the sweep that asks it; the message is one line."""


@dataclass(frozen=True)
class Finished:
    """
    What came of a run.

    Attributes
    ----------
    metrics : dict
        Every metric that is one value; empty if the run failed.
    error, traceback : str
        What went wrong, in one line and in full; empty if nothing did.
    is_lasting : bool
        Whether another try would give the same.
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
    Fly a run and return the outcome, a failure of the run included.

    Parameters
    ----------
    scenario_json : str
        Resolved scenario.
    source : str
        `source_version` of the sweep that asks.

    Raises
    ------
    SourceMismatchError
        When this process has another source.

    """
    if source_version() != source:
        raise SourceMismatchError(
            f"a worker has other source or packages ({source_version()}) than this machine ({source}); "
            "allowed: the same checkout, Python and packages everywhere"
        )
    try:
        flight = fly(scenario_from_json(scenario_json))
    except Exception as error:
        failure = Failure.of(error)
        is_lasting = not isinstance(error, OSError | MemoryError)
        return Finished({}, failure.line, failure.traceback, is_lasting)
    return Finished(_scalars(flight.metrics), wall_s=flight.wall_s, cpu_s=flight.cpu_s)


def _scalars(metrics: dict[str, Any]) -> dict[str, Scalar]:
    """Return the metrics that are one value, without `NO_RESULTS`."""
    return {
        key: value
        for key, value in metrics.items()
        if key not in NO_RESULTS and (value is None or isinstance(value, bool | int | float | str))
    }
