"""
Torpedoes on one thread: the hulls alone, RK4 with a step of 0.1 s, and one vehicle under guidance and
autopilots.

Rates are vehicle-steps per second of processor time; a step has four evaluations of all forces.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterator

from auv_core.compiled import use_compiler
from auv_core.models import make_model
from auv_core.params import Section
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.scenario.loading import load_scenario
from benchmarks.rows import Row, cpu_seconds, spread, taking_turns

PLANT_BAR = 1_000_000.0
STEPS, DT_S = 2000, 0.1
COMMAND, CURRENT_NED_MPS = (0.1, -0.05, 1000.0), (0.2, -0.1, 0.0)


def plant_rate(section: Section, block_s: float) -> float:
    """Return the vehicle-steps per second of processor time of a hull alone."""
    model = make_model(section)
    start = model.initial_state((0.0, 0.0, 30.0), 0.3, 1.5)
    return STEPS / cpu_seconds(lambda: model.step(start, COMMAND, CURRENT_NED_MPS, DT_S, STEPS), block_s)


def rows(*, quick: bool = False) -> Iterator[Row]:
    """Yield all rows; `quick` gives figures that say only whether all works."""
    use_compiler()
    blocks, block_s = (1, 0.01) if quick else (7, 0.4)
    steps = load_scenario("torpedo_steps").vehicles[0].model
    plant_rate(steps, 0.0)
    (rates,) = taking_turns([lambda: plant_rate(steps, block_s)], blocks)
    yield Row(
        "remus100, hull alone: vehicle-steps/s",
        spread(rates),
        bar=f"at least {PLANT_BAR:,.0f}",
        kept=statistics.median(rates) >= PLANT_BAR,
    )
    job = load_scenario("torpedo_path", duration_s=5.0 if quick else 300.0)
    run_in_process(job)
    (paces,) = taking_turns([lambda: job.duration_s / cpu_seconds(lambda: run_in_process(job), 0.0)], blocks)
    yield Row("torpedo_path, one vehicle, with its recording: times real time", spread(paces))
