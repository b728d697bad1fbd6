"""
Flights whose ticks, processor time and memory are measured from outside: ours with its bag, or the bare
message pattern, in the processes of a layout.
"""

from __future__ import annotations

import dataclasses
import os
import select
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from importlib import import_module
from multiprocessing.sharedctypes import RawValue
from pathlib import Path
from typing import Any

import yaml

from auv_bringup.launching.layout import process_specs
from auv_bringup.launching.node_specs import NodeSpec, node_specs
from auv_bringup.launching.node_start import Part, adopt, log_name, node_environment, parts_of
from auv_core.machine.child_start import schedule_as_batch
from auv_core.machine.processes import ChildProcesses
from auv_experiment.compose import compile_ahead
from auv_experiment.scenario.file import SCENARIOS_DIR
from auv_experiment.scenario.loading import load_scenario
from auv_experiment.scenario.schema import Scenario

MAIN_JOB = "flock_acoustic"
OURS, PLAIN, LEAN = "ours", "plain", "lean"
"""The kinds of flights: our nodes with their bag, or one of the bare message patterns."""
PROFILES = "FASTRTPS_DEFAULT_PROFILES_FILE"
DURATION_S = 1e5
_PATIENCE_S = 120.0
_WARM_TICKS = 30


@dataclasses.dataclass(frozen=True)
class Block:
    """Cost of one block of a flight; memory is the proportional set size of each process (MiB)."""

    ticks_per_s: float
    cpu_us_per_tick: float
    memory_mib: list[float]


def fleet_scenario(count: int, folder: Path) -> Scenario:
    """Return the main job with another number of vehicles at the same initial density."""
    raw = yaml.safe_load((SCENARIOS_DIR / f"{MAIN_JOB}.yaml").read_text(encoding="utf-8"))
    vehicles = raw["vehicles"]
    raw["random_starts"]["radius_m"] *= max(1.0, (count / len(vehicles)) ** 0.5)
    raw["vehicles"] = [{**vehicles[0], "id": f"auv_{k + 1}"} for k in range(count)]
    raw["duration_s"] = DURATION_S
    path = folder / f"fleet_{count}.yaml"
    path.write_text(yaml.safe_dump(raw), encoding="utf-8")
    return load_scenario(str(path))


def run_ours(parts: Sequence[Part], environ: dict[str, str], tick: Any) -> int:
    """Run as a process of our nodes."""
    from auv_bringup.nodes.node_container import run
    from auv_sim.nodes.clock_node import ClockNode

    begin = ClockNode.begin_tick

    def counted(clock: ClockNode, number: int) -> None:
        tick.value = number
        begin(clock, number)

    node_class: Any = ClockNode
    node_class.begin_tick = counted
    schedule_as_batch()
    adopt(environ)
    return run(parts)


def run_bare(
    nodes: Sequence[NodeSpec], fleet: Sequence[str], environ: dict[str, str], tick: Any, *, is_lean: bool
) -> int:
    """Run as a process of a bare pattern; the plain one uses default middleware and scheduling."""
    from benchmarks.bare_pattern import run

    if is_lean:
        schedule_as_batch()
    else:
        environ = {name: value for name, value in environ.items() if name != PROFILES}
        environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"

    def count(number: int) -> None:
        tick.value = number

    adopt(environ)
    return run(nodes, fleet, count, is_lean=is_lean)


@contextmanager
def flight(scenario: Scenario, layout: str, what: str) -> Iterator[tuple[ChildProcesses, Any]]:
    """Fly until the block ends; yield the processes and their shared tick."""
    environ = node_environment(
        os.environ, domain_id=int(os.environ.get("ROS_DOMAIN_ID") or 0), discovery="localhost"
    )
    tick = RawValue("q", -1)
    fleet = [vehicle.id for vehicle in scenario.vehicles]
    compile_ahead(scenario, print)
    with tempfile.TemporaryDirectory() as name, _ends_awaited() as orphans, ChildProcesses() as children:
        folder = Path(name)
        nodes = node_specs(scenario, mode="lockstep", bag_dir=folder / "bag")
        for module in sorted({node.module for node in nodes} | {"benchmarks.bare_pattern"}):
            import_module(module)
        for process in process_specs(nodes, layout):
            run: Callable[[], int] = (
                partial(run_ours, parts_of(process, folder), environ, tick)
                if what == OURS
                else partial(run_bare, process.nodes, fleet, environ, tick, is_lean=what == LEAN)
            )
            children.fork(process.name, run, log=folder / f"{log_name(process.name)}.log")
        try:
            yield children, tick
        except TimeoutError:
            for log in sorted(folder.glob("*.log")):
                print(log.name, log.read_text(encoding="utf-8")[-2000:])
            raise
        finally:
            found = [pid for each in children.running for pid in family(children.pid(each))[1:]]
            orphans += map(os.pidfd_open, found)


@contextmanager
def _ends_awaited() -> Iterator[list[int]]:
    """
    Yield a list of process watches; on exit wait until the processes have ended, since a bag must be closed.
    """
    watches: list[int] = []
    try:
        yield watches
    finally:
        for watch in watches:
            select.select([watch], [], [], _PATIENCE_S)
            os.close(watch)


def measure(scenario: Scenario, layout: str, what: str, *, block_s: float) -> Block:
    """Return the cost of a block of `block_s` of a new flight."""
    with flight(scenario, layout, what) as (children, tick):
        deadline_s = time.monotonic() + _PATIENCE_S
        while tick.value < _WARM_TICKS:
            if time.monotonic() > deadline_s or children.collect_exits():
                raise TimeoutError(f"{len(scenario.vehicles)} vehicles, {layout}: no flight")
            time.sleep(0.01)
        pids = [pid for name in children.running for pid in family(children.pid(name))]
        first, first_s, first_cpu_us = tick.value, time.monotonic(), sum(map(cpu_us, pids))
        time.sleep(block_s)
        ticks, wall_s = tick.value - first, time.monotonic() - first_s
        spent_us = sum(map(cpu_us, pids)) - first_cpu_us
        return Block(ticks / wall_s, spent_us / ticks, [pss_mib(pid) for pid in pids])


def family(pid: int) -> list[int]:
    """Return a process and all of its descendants."""
    found = [pid]
    for path in Path(f"/proc/{pid}/task").glob("*/children"):
        with suppress(OSError):  # it has just ended
            for child in map(int, path.read_text().split()):
                found += family(child)
    return found


def cpu_us(pid: int) -> float:
    """Return the processor time of all threads of a process (us)."""
    tasks = Path(f"/proc/{pid}/task").iterdir()
    return sum(int((task / "schedstat").read_text().split()[0]) for task in tasks) / 1e3


def pss_mib(pid: int) -> float:
    """
    Return the proportional set size of a process (MiB): shared memory counts in proportion. 0 for a process
    that has just ended.
    """
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    except OSError:
        return 0.0
    return next((int(line.split()[1]) / 1024.0 for line in lines if line.startswith("Pss:")), 0.0)
