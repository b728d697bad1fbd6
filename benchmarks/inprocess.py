"""
The whole stack in one process: hulls, agents, acoustic medium, filters, record and metrics.

The comparison value is the physics alone: the same steps of the same hulls by the same function. Seconds are
processor time, which other work on the machine disturbs least.
"""

from __future__ import annotations

import os
import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from auv_core.cli.tally import Tally
from auv_core.compiled import use_compiler
from auv_experiment.compose import vehicle_configs
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.scenario.loading import load_scenario
from auv_experiment.scenario.schema import Scenario
from auv_sim.vehicle import Vehicle
from auv_thesis.items import RunSpec
from auv_thesis.runs.runner import fly_all
from auv_thesis.runs.store import Store
from benchmarks.rows import Row, cpu_seconds, spread, taking_turns

JOB = ("flock_acoustic", ("dt_s=0.01",))
JOB_BAR, SEEDS_BAR_MIN = 400.0, 20.0
THOUSAND = 1000
COUNTS = (4, 8, 16, 32, 64)


def rows(*, quick: bool = False) -> Iterator[Row]:
    """Yield all rows; `quick` only checks that everything works."""
    use_compiler()
    name, changes = JOB
    job = load_scenario(name, overrides=changes, duration_s=5.0 if quick else 650.0)
    fly(job)
    blocks = 1 if quick else 5
    yield whole_stack(job, blocks)
    yield thousand_seeds(2 if quick else 16, job.duration_s)
    yield growth(COUNTS[:2] if quick else COUNTS, blocks, 2.0 if quick else 20.0)


def fly(scenario: Scenario) -> None:
    """Fly a scenario and compute its metrics."""
    recording = run_in_process(scenario)
    compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)


def physics(scenario: Scenario) -> None:
    """Make the steps of the hulls alone."""
    vehicles = [Vehicle(config) for config in vehicle_configs(scenario)]
    for _ in range(scenario.ticks):
        for vehicle in vehicles:
            vehicle.step(None)


def whole_stack(job: Scenario, blocks: int) -> Row:
    """Return how many times faster than real time the main job is, with its metrics."""

    def rate() -> float:
        return job.duration_s / cpu_seconds(lambda: fly(job), 0.0)

    def physics_rate() -> float:
        return job.duration_s / cpu_seconds(lambda: physics(job), 0.0)

    ours, alone = taking_turns((rate, physics_rate), blocks)
    ratio = statistics.median(a / b for a, b in zip(ours, alone, strict=True))
    return Row(
        "flock_acoustic, dynamics at 0.01 s, with metrics: times real time",
        spread(ours),
        f"its hulls alone: {spread(alone)}",
        f"{ratio:.2f}",
        f"at least {JOB_BAR:g}",
        statistics.median(ours) >= JOB_BAR,
    )


def thousand_seeds(count: int, duration_s: float) -> Row:
    """Return the duration of a thousand seeds on all cores, estimated from `count` of them."""
    name, changes = JOB
    specs = [
        RunSpec(name, (*changes, f"seed={seed}"), duration_s, keep_recording=False)
        for seed in range(1, count + 1)
    ]
    n_workers = len(os.sched_getaffinity(0))
    with tempfile.TemporaryDirectory() as folder, Tally("runs") as tally:
        began_s = time.perf_counter()
        flown = fly_all(specs, Store(Path(folder)), n_workers=n_workers, tally=tally)
        wall_min = (time.perf_counter() - began_s) / 60.0
    if flown.failed:
        raise RuntimeError(f"{len(flown.failed)} of the benchmark's runs failed")
    minutes = wall_min * THOUSAND / count
    return Row(
        f"1000 seeds of {duration_s:g} s on {n_workers} cores, from {count}: minutes",
        f"{minutes:.1f}",
        bar=f"at most {SEEDS_BAR_MIN:g}",
        kept=minutes <= SEEDS_BAR_MIN,
    )


def growth(counts: tuple[int, ...], blocks: int, duration_s: float) -> Row:
    """
    Return the cost of a control period by number of vehicles that all hear each other, and its exponent.
    """
    jobs = [_fleet(count, duration_s) for count in counts]
    measures = [lambda job=job: cpu_seconds(lambda: run_in_process(job), 0.0) / job.ticks for job in jobs]
    found = taking_turns(measures, blocks)
    costs_us = [1e6 * statistics.median(values) for values in found]
    exponent = float(np.polyfit(np.log(counts), np.log(costs_us), 1)[0])
    shown = ", ".join(f"{count}: {cost:,.0f}" for count, cost in zip(counts, costs_us, strict=True))
    return Row(
        "flock_acoustic, cost of a control period by number of vehicles: microseconds",
        shown,
        "every vehicle tracks every other",
        f"exponent {exponent:.2f}",
    )


def _fleet(count: int, duration_s: float) -> Scenario:
    """Return the main job with another number of vehicles at the same initial density."""
    vehicles = ", ".join(f"{{id: auv_{k}, model: {{preset: odin}}}}" for k in range(1, count + 1))
    radius_m = round(10.0 * (count / 4) ** (1 / 3), 1)
    changes = (f"vehicles=[{vehicles}]", f"random_starts.radius_m={radius_m}")
    return load_scenario(JOB[0], overrides=(*JOB[1], *changes), duration_s=duration_s)
