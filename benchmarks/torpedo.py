"""
Torpedoes on one thread: the hull alone, with guidance and autopilots in one compiled loop, and whole runs.

Rates are vehicle-steps per second of processor time; a step has four evaluations of all forces. The peer's is
one forward Euler step without a controller.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterator
from pathlib import Path

from auv_core.compiled import use_compiler
from auv_core.models import make_model
from auv_core.params import Section
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.scenario.loading import load_scenario
from benchmarks.inprocess import fly, physics
from benchmarks.peers import Peer
from benchmarks.rows import Row, cpu_seconds, spread, taking_turns
from benchmarks.torpedo_loop import TorpedoRun

PLANT_BAR, LAWS_BAR, FLEET_BAR = 1_000_000.0, 300_000.0, 400.0
PEER = "auv_sim_bench"
STEPS, DT_S = 2000, 0.1
COMMAND, CURRENT_NED_MPS = (0.1, -0.05, 1000.0), (0.2, -0.1, 0.0)


def plant_rate(section: Section, block_s: float) -> float:
    """Return the vehicle-steps per second of processor time of a hull alone."""
    model = make_model(section)
    start = model.initial_state((0.0, 0.0, 30.0), 0.3, 1.5)
    return STEPS / cpu_seconds(lambda: model.step(start, COMMAND, CURRENT_NED_MPS, DT_S, STEPS), block_s)


def rows(*, quick: bool = False, peers: Path | None = None) -> Iterator[Row]:
    """Yield all rows; `quick` gives figures that say only whether all works, `peers` is their Python."""
    use_compiler()
    blocks, block_s = (1, 0.01) if quick else (7, 0.4)
    yield from loops(blocks, block_s, peers)
    yield one_vehicle(blocks, 5.0 if quick else 300.0)
    yield fleet(1 if quick else 5, 5.0 if quick else 900.0)


def loops(blocks: int, block_s: float, peers: Path | None) -> Iterator[Row]:
    """Yield the rates of the hull alone and of hull and laws, in turns with those of a peer."""
    hull = load_scenario("torpedo_steps").vehicles[0].model
    run = TorpedoRun(load_scenario("torpedo_path", duration_s=100.0))
    plant_rate(hull, 0.0)
    run.fly()
    with Peer(PEER, 1, peers) as peer:
        measures = [lambda: plant_rate(hull, block_s), lambda: run.steps / cpu_seconds(run.fly, block_s)]
        if not peer.absent:
            measures.append(lambda: peer.rate(block_s))
        found = taking_turns(measures, blocks)
        names = ("hull alone", "with guidance and autopilots")
        for name, rates, bar in zip(names, found, (PLANT_BAR, LAWS_BAR), strict=False):
            ratios = [a / b for a, b in zip(rates, found[2], strict=True)] if len(found) > 2 else []
            yield Row(
                f"remus100, {name}: vehicle-steps/s",
                spread(rates),
                f"{PEER}: {spread(found[2]) if ratios else peer.absent}",
                spread(ratios) if ratios else "",
                f"at least {bar:,.0f}",
                statistics.median(rates) >= bar,
            )


def one_vehicle(blocks: int, duration_s: float) -> Row:
    """Return how many times faster than real time one vehicle on a path is."""
    job = load_scenario("torpedo_path", duration_s=duration_s)
    run_in_process(job)
    (paces,) = taking_turns([lambda: job.duration_s / cpu_seconds(lambda: run_in_process(job), 0.0)], blocks)
    return Row("torpedo_path, one vehicle, with its recording: times real time", spread(paces))


def fleet(blocks: int, duration_s: float) -> Row:
    """Return how many times faster than real time a fleet of five is, with its metrics."""
    job = load_scenario("torpedo_fleet", duration_s=duration_s)
    fly(job)
    measures = [
        lambda: duration_s / cpu_seconds(lambda: fly(job), 0.0),
        lambda: duration_s / cpu_seconds(lambda: physics(job), 0.0),
    ]
    paces, alone = taking_turns(measures, blocks)
    return Row(
        "torpedo_fleet, five vehicles, with metrics: times real time",
        spread(paces),
        f"its hulls alone: {spread(alone)}",
        f"{statistics.median(a / b for a, b in zip(paces, alone, strict=True)):.2f}",
        f"at least {FLEET_BAR:g}",
        statistics.median(paces) >= FLEET_BAR,
    )
