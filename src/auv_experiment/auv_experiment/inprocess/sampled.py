"""A scenario in one process, without ROS: the same objects as the nodes, called in the same order."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from auv_core.compiled import use_compiler
from auv_experiment.inprocess.continuous import run_continuous
from auv_experiment.inprocess.stepwise import StepwiseRun
from auv_experiment.recording import Recording
from auv_experiment.run_memory import check_memory
from auv_experiment.scenario.schema import Scenario

Progress = Callable[[float], None]

_COLLECT_EVERY = 100_000


def run_in_process(scenario: Scenario, *, on_progress: Progress | None = None) -> Recording:
    """
    Fly a scenario and return its recording.

    Parameters
    ----------
    scenario : Scenario
        Resolved scenario, sampled or continuous.
    on_progress : callable, optional
        Called from time to time with the scenario time reached (s).

    Raises
    ------
    ConfigError
        If the run does not fit into the free memory.

    """
    check_memory(scenario)
    use_compiler()
    with _rare_collections():
        if scenario.sampling == "continuous":
            return run_continuous(scenario, on_progress=on_progress)
        return _run_sampled(scenario, on_progress)


@contextmanager
def _rare_collections() -> Iterator[None]:
    """Run the garbage collector rarely: a run makes many short-lived objects, but no reference cycles."""
    usual = gc.get_threshold()
    gc.set_threshold(_COLLECT_EVERY, *usual[1:])
    try:
        yield
    finally:
        gc.set_threshold(*usual)


def _run_sampled(scenario: Scenario, on_progress: Progress | None) -> Recording:
    run = StepwiseRun(scenario)
    while run.tick < scenario.ticks:
        run.act(run.decide())
        if on_progress is not None and run.tick % 100 == 0:
            on_progress(run.tick * scenario.period_s)
    return run.recording()
