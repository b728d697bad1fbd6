"""
The kernel alone, on one thread: hulls in six degrees of freedom, RK4, PI velocity loop, flocking law, pair
forces and consensus, all evaluated in each of the four stages of a step.

It is the loop that flies the scenario ``swarm`` (`auv_experiment.inprocess.fleet_loop`), without a
recording. A peer does less work: one forward Euler step of every vehicle's dynamics, no neighbours, no
controller. Rates are vehicle-steps per second of processor time, which other work on the machine disturbs
least.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from auv_core.compiled import use_compiler
from auv_experiment.inprocess.continuous import run_continuous
from auv_experiment.inprocess.fleet import Fleet
from auv_experiment.scenario.loading import load_scenario
from benchmarks.peers import PEERS, Peer
from benchmarks.rows import Row, cpu_seconds, spread, taking_turns

COUNTS = (4, 16, 64, 256, 1024, 4096)
BARS = {4: 200.0, 64: 150.0}
GROWTH_FROM, GROWTH_BAR = 64, 1.15
REACH_M = 10.0
SPACE_M = 6.0
LEAST_TICKS, STEPS, DT_S = 100, 5, 0.02
FEW_VEHICLE_TICKS = 4000


class FleetRun:
    """
    `swarm` without its path, N vehicles on a cubic grid of 6 m, disturbed by up to half a metre, which hear
    to 10 m and keep 4 m apart; every block flies the same ten seconds from there, fewer than 40 vehicles
    longer.
    """

    def __init__(self, count: int, ticks: int | None = None) -> None:
        overrides = ["vehicles.count=1", f"agent.consensus.params.reach_m={REACH_M}"]
        one = load_scenario("swarm", overrides=[*overrides, "agent.flocking.params.path_gain_ps=0.0"])
        self.count = count
        self._ticks = ticks or max(LEAST_TICKS, FEW_VEHICLE_TICKS // count)
        self._fleet = Fleet(one, _grid(count))
        self._paths = self._fleet.paths(0, self._ticks * STEPS, DT_S)
        self._start = self._fleet.motion.copy(), self._fleet.centres.copy()

    def fly(self) -> None:
        """Fly once, from the start."""
        self._fleet.motion[:], self._fleet.centres[:] = self._start
        self._fleet.run(self._ticks, STEPS, DT_S, self._paths)

    def rate(self, block_s: float) -> float:
        """Return vehicle-steps per second of processor time, over a block of this length."""
        return self.count * self._ticks * STEPS / cpu_seconds(self.fly, block_s)


def rows(*, quick: bool = False, peers: Path | None = None) -> Iterator[Row]:
    """Yield all rows; `quick` gives figures that say only whether all works, `peers` is their Python."""
    use_compiler()
    blocks, block_s = (1, 0.01) if quick else (7, 0.4)
    counts = COUNTS[:3] if quick else COUNTS
    yield from beside_peers(blocks, block_s, peers)
    yield from growth(counts, blocks, block_s)
    yield from whole_runs(blocks, 2.0 if quick else 20.0)
    yield memory(counts[-1])
    yield noise(blocks)


def beside_peers(blocks: int, block_s: float, peers: Path | None) -> Iterator[Row]:
    """Yield the rate for a few vehicles and for many, in turns with the same number of a peer's."""
    for count, bar in BARS.items():
        flight = FleetRun(count)
        flight.fly()
        name = f"kernel, {count} vehicles: vehicle-steps/s"
        for peer in PEERS:
            with Peer(peer, count, peers) as other:
                if other.absent:
                    yield Row(name, "", f"{peer}: {other.absent}")
                    continue
                measures = [lambda: flight.rate(block_s), lambda: other.rate(block_s)]  # noqa: B023
                rates, theirs = taking_turns(measures, blocks)
            ratios = [a / b for a, b in zip(rates, theirs, strict=True)]
            ratio = statistics.median(ratios)
            asked: dict[str, Any] = (
                {"bar": f"at least {bar:g}", "kept": ratio >= bar} if peer == "auv_sim_bench" else {}
            )
            yield Row(name, spread(rates), f"{peer}: {spread(theirs)}", spread(ratios), **asked)


def growth(counts: tuple[int, ...], blocks: int, block_s: float) -> Iterator[Row]:
    """Yield the rates at one density and the exponent of the cost of a step in the number of vehicles."""
    flights = [FleetRun(count) for count in counts]
    for flight in flights:
        flight.fly()
    found = taking_turns([partial(flight.rate, block_s) for flight in flights], blocks)
    for flight, rates in zip(flights, found, strict=True):
        yield Row(f"kernel, {flight.count} vehicles at one density: vehicle-steps/s", spread(rates))
    chosen = [i for i, count in enumerate(counts) if count >= GROWTH_FROM] or list(range(len(counts)))
    costs = [counts[i] / statistics.median(found[i]) for i in chosen]
    sizes = [counts[i] for i in chosen]
    exponent = float(np.polyfit(np.log(sizes), np.log(costs), 1)[0]) if len(sizes) > 1 else 1.0
    yield Row(
        f"kernel: exponent of the cost of a step from N = {sizes[0]} to {sizes[-1]}",
        f"{exponent:.2f}",
        bar=f"at most {GROWTH_BAR:g}",
        kept=exponent <= GROWTH_BAR,
    )


def whole_runs(blocks: int, duration_s: float) -> Iterator[Row]:
    """Yield the rate of `swarm` from a scenario to its recording, beside the kernel alone."""
    for count in BARS:
        overrides = [f"vehicles.count={count}", f"agent.consensus.params.reach_m={REACH_M}"]
        scenario = load_scenario("swarm", duration_s=duration_s, overrides=overrides)
        steps = count * round(duration_s / scenario.dt_s)
        flight = FleetRun(count)
        measures = [
            lambda: steps / cpu_seconds(lambda: run_continuous(scenario), 0.0),  # noqa: B023
            lambda: flight.rate(0.1),  # noqa: B023
        ]
        rates, alone = taking_turns(measures, blocks)
        ratios = [a / b for a, b in zip(rates, alone, strict=True)]
        yield Row(
            f"swarm, {count} vehicles, with its recording: vehicle-steps/s",
            spread(rates),
            f"kernel alone: {spread(alone)}",
            spread(ratios, "{:.2f}"),
        )


def memory(count: int) -> Row:
    """Return the memory of an additional vehicle in flight, from two processes with few and many."""
    least, most = (_peak_kib(n) for n in (COUNTS[0], count))
    each_kib = (most - least) / (count - COUNTS[0])
    return Row(
        f"kernel, {count} vehicles: memory per vehicle, KiB",
        f"{each_kib:.1f}",
        f"{least / 1024:.0f} MiB without",
    )


def _peak_kib(count: int) -> int:
    program = f"from benchmarks import kernel; kernel.print_peak({count})"
    done = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True, timeout=300
    )
    return int(done.stdout)


def print_peak(count: int) -> None:
    """Fly `count` vehicles for one tick and print the peak memory of this process (KiB)."""
    use_compiler()
    FleetRun(count, ticks=1).fly()
    status = Path("/proc/self/status").read_text(encoding="ascii")
    print(next(line.split()[1] for line in status.splitlines() if line.startswith("VmHWM")))


def noise(blocks: int) -> Row:
    """Return the duration of a fixed piece of plain Python, and its share of the processor."""
    wall_ms, shares = [], []
    for _ in range(blocks):
        began_s, began_cpu_s = time.perf_counter(), time.process_time()
        sum(i * i for i in range(200_000))
        wall_s = time.perf_counter() - began_s
        wall_ms.append(1e3 * wall_s)
        shares.append((time.process_time() - began_cpu_s) / wall_s)
    return Row(
        "noise: a fixed piece of Python, ms",
        spread(wall_ms, "{:.1f}"),
        f"{spread(shares, '{:.2f}')} of a core",
    )


def _grid(count: int) -> list[tuple[float, float, float]]:
    """Return disturbed starts on a grid around a point at sufficient depth."""
    side = round(np.ceil(count ** (1.0 / 3.0) - 1e-9))
    corner = np.indices((side, side, side)).reshape(3, -1).T[:count] * SPACE_M
    shaken = corner + np.random.default_rng(count).uniform(-0.5, 0.5, (count, 3)) + (0.0, 0.0, SPACE_M)
    return [tuple(row) for row in shaken.tolist()]
