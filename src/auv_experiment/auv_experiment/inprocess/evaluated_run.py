"""One run in this process, with its durations."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from auv_experiment.recording import Recording
    from auv_experiment.scenario.schema import Scenario


@dataclass(frozen=True, eq=False)
class EvaluatedRun:
    """A finished run: its recording, its metrics, and its wall and processor time (s)."""

    recording: Recording
    metrics: dict[str, Any]
    wall_s: float
    cpu_s: float


def load_source() -> None:
    """Load all that runs need, so that processes forked later fly with it, whatever changes on disk."""
    import auv_experiment.inprocess.sampled
    import auv_experiment.metrics.run  # noqa: F401
    from auv_experiment.metrics.own import own_files_of_metrics

    own_files_of_metrics()


def run_evaluated(scenario: Scenario, *, on_progress: Callable[[float], None] | None = None) -> EvaluatedRun:
    """
    Fly a resolved scenario in this process and evaluate it.

    Parameters
    ----------
    scenario : Scenario
        Sampled or continuous.
    on_progress : callable, optional
        Called from time to time with the scenario time reached (s).

    Raises
    ------
    ConfigError
        When a file of own metrics cannot be used; nothing is flown.
    DivergedError
        If a motion has no finite solution.

    """
    from auv_experiment.inprocess.sampled import run_in_process
    from auv_experiment.metrics.own import own_files_of_metrics
    from auv_experiment.metrics.run import compute_metrics

    own_files_of_metrics()
    start_s, cpu_start_s = time.monotonic(), time.process_time()
    recording = run_in_process(scenario, on_progress=on_progress)
    factor = scenario.duration_s / max(time.monotonic() - start_s, 1e-9)
    metrics = compute_metrics(recording, scenario, mode="inprocess", real_time_factor=factor)
    return EvaluatedRun(recording, metrics, time.monotonic() - start_s, time.process_time() - cpu_start_s)


def effort(scenario: Scenario) -> float:
    """Return the expected work of a run, in evaluations of a law."""
    n = len(scenario.vehicles)
    if scenario.sampling == "continuous":
        return n * 4.0 * scenario.duration_s / scenario.dt_s
    return n * scenario.duration_s * (1.0 / scenario.dt_s + (8.0 + 4.0 * n) / scenario.period_s)
