"""
How fast the main job runs, in one process and in lock-step, each beside its limit measured in the same run.

    source install/setup.bash && python benchmarks/speed.py

Every figure is the median of `--repeats` measurements.  Machines are noisy: compare the ratios.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from auv_bringup.compose import vehicle_configs
from auv_bringup.experiment import run_in_process
from auv_bringup.results import read_json
from auv_bringup.scenario import Scenario, load_scenario
from auv_sim.vehicle import Vehicle

SCENARIO = "flock_acoustic"
_LIMIT_S = 600.0


def in_process(scenario: Scenario) -> float:
    """Return simulated seconds per second of the whole stack in one process."""
    began_s = time.perf_counter()
    run_in_process(scenario)
    return scenario.duration_s / (time.perf_counter() - began_s)


def physics_alone(scenario: Scenario) -> float:
    """Return the same for the vehicles alone: no agents, no medium, no record."""
    vehicles = [Vehicle(config) for config in vehicle_configs(scenario)]
    began_s = time.perf_counter()
    for _ in range(scenario.ticks):
        for vehicle in vehicles:
            vehicle.step(None)
    return scenario.duration_s / (time.perf_counter() - began_s)


def lockstep(scenario: Scenario) -> float:
    """Return simulated seconds per second of a lock-step flight with the bag on, ten processes."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "auv_bringup.cli", scenario.name, "--out", folder, "--no-figures"]
        command += ["--duration", str(scenario.duration_s)]
        subprocess.run(
            command, check=True, timeout=_LIMIT_S, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        (results,) = Path(folder).iterdir()
        return float(read_json(results / "metrics.json")["real_time_factor"])


def bare_barrier(scenario: Scenario) -> float:
    """Return the same for as many processes that only answer ticks."""
    import bare_barrier

    return bare_barrier.measure(2 * len(scenario.vehicles), 2000) * scenario.period_s


def median(measure: Callable[[Scenario], float], scenario: Scenario, repeats: int) -> float:
    """Return the median of several measurements."""
    return statistics.median(measure(scenario) for _ in range(repeats))


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=3, help="measurements per figure (default: 3)")
    parser.add_argument("--seconds", type=float, default=60.0, help="simulated time of each (s; default: 60)")
    options = parser.parse_args()
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    scenario = load_scenario(SCENARIO, duration_s=options.seconds)
    rows = (
        ("in process, whole stack", in_process, "physics alone", physics_alone),
        ("lock-step, bag on", lockstep, "bare barrier of as many processes", bare_barrier),
    )
    print(f"{SCENARIO}, {len(scenario.vehicles)} vehicles, x real time, median of {options.repeats}")
    for name, measure, limit_name, measure_limit in rows:
        rate = median(measure, scenario, options.repeats)
        limit = median(measure_limit, scenario, options.repeats)
        print(f"{name:26s} {rate:8.1f}    {limit_name:34s} {limit:8.1f}    ratio {rate / limit:.2f}")


if __name__ == "__main__":
    main()
