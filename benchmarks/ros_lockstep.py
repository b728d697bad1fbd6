"""
The ROS part of the benchmark: rate of lock-step compared with its bare message pattern, cost against the
number of vehicles, start-up and memory.

Rates drift with other work on the machine. Ratios come from alternating blocks, and processor time drifts
least.
"""

from __future__ import annotations

import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from auv_bringup.launching.layout import LAYOUTS
from auv_bringup.launching.node_start import ONE_THREAD
from auv_experiment.scenario.loading import load_scenario
from auv_experiment.scenario.schema import Scenario
from benchmarks.ros_flights import (
    DURATION_S,
    LEAN,
    MAIN_JOB,
    OURS,
    PLAIN,
    Block,
    family,
    fleet_scenario,
    measure,
    pss_mib,
)
from benchmarks.rows import Row, spread

_START_LIMIT_S = 120.0
_LOOK_S = 0.05
_OF_BARE_BAR = 0.6
_FACTOR_BARS = {
    ("node", 4): ("about 40 on a quiet machine: at least 36", 36.0),
    ("vehicle", 4): ("about 70 on a quiet machine: at least 63", 63.0),
    ("single", 4): ("about 110 on a quiet machine: at least 99", 99.0),
    ("vehicle", 16): ("at least 5", 5.0),
}
_MANY, _MANY_BAR = 32, 1.0
_START_BAR_S, _MEMORY_BAR_MIB = 5.0, 1229.0


def rates(scenario: Scenario, layout: str, blocks: int, block_s: float) -> Iterator[Row]:
    """Yield rate and processor time of a layout and of both bare patterns, in alternating blocks."""
    found: dict[str, list[Block]] = {OURS: [], PLAIN: [], LEAN: []}
    for _ in range(blocks):
        for what, measured in found.items():
            measured.append(measure(scenario, layout, what, block_s=block_s))
    ours = found[OURS]
    name = f"lock-step, {len(scenario.vehicles)} vehicles, {layout}"
    for what, of_bare in ((PLAIN, _OF_BARE_BAR), (LEAN, None)):
        pairs = list(zip(ours, found[what], strict=True))
        ratios = [a.ticks_per_s / b.ticks_per_s for a, b in pairs]
        yield Row(
            f"{name}: ticks/s",
            spread([block.ticks_per_s for block in ours]),
            f"{what} pattern: {spread([block.ticks_per_s for block in found[what]])}",
            spread(ratios, "{:.2f}"),
            f"at least {of_bare:g}" if of_bare else "",
            statistics.median(ratios) >= of_bare if of_bare else None,
        )
        yield Row(
            f"{name}: CPU us/tick",
            spread([block.cpu_us_per_tick for block in ours]),
            f"{what} pattern: {spread([block.cpu_us_per_tick for block in found[what]])}",
            spread([b.cpu_us_per_tick / a.cpu_us_per_tick for a, b in pairs], "{:.2f}"),
        )
    factor = statistics.median(block.ticks_per_s for block in ours) * scenario.period_s
    bar, least = _FACTOR_BARS[layout, len(scenario.vehicles)]
    yield Row(f"{name}: times real time", f"{factor:.0f}", bar=bar, kept=factor >= least)
    memory = ours[-1].memory_mib
    yield Row(
        f"{name}: memory, MiB (PSS)",
        f"{sum(memory):.0f} in {len(memory)} processes, {max(memory):.0f} the largest",
    )


def growth(counts: Sequence[int], layout: str, blocks: int, block_s: float) -> Iterator[Row]:
    """Yield processor time against the number of vehicles, and the exponent of a power law through it."""
    costs: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        for count in counts:
            scenario = fleet_scenario(count, Path(folder))
            found = [measure(scenario, layout, OURS, block_s=block_s) for _ in range(blocks)]
            costs.append(statistics.median(block.cpu_us_per_tick for block in found))
            rate = statistics.median(block.ticks_per_s for block in found)
            factor = rate * scenario.period_s
            is_asked = count == _MANY
            yield Row(
                f"lock-step, {count} vehicles, {layout}: CPU us/tick",
                f"{costs[-1]:.0f}",
                f"{factor:.1f} times real time",
                bar=f"at least {_MANY_BAR:g} times" if is_asked else "",
                kept=factor >= _MANY_BAR if is_asked else None,
            )
    exponent = np.polyfit(np.log(counts), np.log(costs), 1)[0]
    yield Row(f"exponent of that from N = {counts[0]} to {counts[-1]}", f"{exponent:.2f}")


def starts(layout: str, count: int) -> Iterator[Row]:
    """Yield the main job's time from the command to the first tick, and its peak memory."""
    found = [_start(layout) for _ in range(count)]
    seconds, most_mib = [each[0] for each in found], [each[1] for each in found]
    yield Row(
        f"start-up, {layout}: s from the command to the first tick, {count} starts",
        f"{statistics.median(seconds):.2f}, at most {max(seconds):.2f}",
        bar=f"at most {_START_BAR_S:g}",
        kept=max(seconds) <= _START_BAR_S,
    )
    yield Row(
        f"main job, {layout}: most memory of all processes, MiB (PSS)",
        f"{max(most_mib):.0f}",
        bar=f"at most {_MEMORY_BAR_MIB:g}",
        kept=max(most_mib) <= _MEMORY_BAR_MIB,
    )


def _start(layout: str) -> tuple[float, float]:
    """Return the time to the first tick (s) and the peak memory (MiB) of a short main job."""
    with tempfile.TemporaryDirectory() as folder:
        command = [
            sys.executable,
            "-m",
            "auv_bringup.tools.run",
            MAIN_JOB,
            "--duration",
            "20",
            "--layout",
            layout,
        ]
        began_s, first_tick_s, most_mib = time.monotonic(), 0.0, 0.0
        errors = Path(folder) / "errors"
        with errors.open("wb") as stream:
            child = subprocess.Popen(
                [*command, "--no-figures", "--out", folder], stdout=subprocess.DEVNULL, stderr=stream
            )
        while child.poll() is None and time.monotonic() - began_s < _START_LIMIT_S:
            if not first_tick_s and re.search("nodes are up", errors.read_text(encoding="utf-8")):
                first_tick_s = time.monotonic() - began_s
            most_mib = max(most_mib, sum(map(pss_mib, family(child.pid))))
            time.sleep(_LOOK_S)
        if child.poll() is None or child.returncode or not first_tick_s:
            child.kill()
            raise TimeoutError(f"the main job did not end well: {errors.read_text(encoding='utf-8')}")
        return first_tick_s, most_mib


def rows(*, quick: bool = False) -> Iterator[Row]:
    """Yield all rows; `quick` gives figures that say only whether all works."""
    os.environ.update({**ONE_THREAD, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"})
    blocks, block_s, start_count = (1, 1.0, 1) if quick else (5, 3.0, 20)
    scenario = load_scenario(MAIN_JOB, duration_s=DURATION_S)
    for layout in LAYOUTS:
        yield from rates(scenario, layout, blocks, block_s)
    with tempfile.TemporaryDirectory() as folder:
        yield from rates(fleet_scenario(16, Path(folder)), "vehicle", blocks, block_s)
    yield from growth((2, 4) if quick else (2, 4, 8, 16, 32), "single", blocks, block_s)
    yield from starts("node", start_count)
    yield from starts("single", start_count)
