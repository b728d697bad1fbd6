"""
Fly a scenario as ROS 2 nodes: start, watch and end them.

The layout groups nodes into processes. The launcher starts all processes at once, listens to
``/flock/status`` through a small process, and lets the `Supervisor` judge the flight. It ends the processes
step by step: first vehicles, agents and relay, which deliver their last messages, then the recorder, which
writes all received messages and closes the bag. Every wait has a limit.

The processes are forked from this one after it has imported their modules, once for all of them, and before
it has threads. This saves most of their start-up time and half of their memory. If this process has threads,
which a fork would lose, they are started from their command lines instead.
"""

from __future__ import annotations

import gc
import math
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from pathlib import Path

from setproctitle import setproctitle, setthreadtitle

from auv_bringup.launching.flight_status import LOST_STATUS
from auv_bringup.launching.layout import ProcessSpec, process_specs, start_patience_s, vehicles_of
from auv_bringup.launching.node_specs import node_specs
from auv_bringup.launching.node_start import (
    CONTAINER_MODULE,
    Part,
    adopt,
    command_line,
    log_name,
    node_environment,
    parts_of,
)
from auv_bringup.launching.shared_memory import clear_shared_memory
from auv_bringup.launching.status_listener import EAR, EAR_MODULE, StatusListener
from auv_bringup.launching.supervision import Supervisor
from auv_core.cli.progress import Progress
from auv_core.machine.child_end import last_lines
from auv_core.machine.child_start import schedule_as_batch, threads_allow_fork
from auv_core.machine.interrupts import Interrupts
from auv_core.machine.processes import SIGINT_GRACE_S, ChildProcesses
from auv_experiment.compose import compile_ahead
from auv_experiment.results import BAG, LOGS
from auv_experiment.scenario.schema import Scenario
from auv_ros.run_config import WallWatch

INTERRUPTED_STATUS = 130
RECORDER_GRACE_S = 30.0
"""The recorder drains for at most 20 s before it closes the bag."""
LOST_HAND_OVER_S = 1.5
"""Time for which processes of a lost run wait for acknowledgements: those of a dead process never come."""
_STOPPED_LOOK_S = 0.5
_MOST_AWAKE_S = 0.5
"""Longer pauses mean that the launcher itself was suspended; they do not count against the nodes."""


@dataclass(frozen=True)
class Flight:
    """
    How a flight ended.

    `exit_status` is 0, 3 (vehicle or node lost, flight stopped) or 130 (interrupted); `reason` says why it
    was stopped. `real_time_factor` is that of the flight without its start, NaN if it was too short.
    `strangers` lists foreign publishers on topics of the run, one line each.
    """

    exit_status: int
    reason: str
    lost_vehicles: tuple[str, ...]
    simulated_s: float
    real_time_factor: float
    start_up_s: float
    strangers: tuple[str, ...] = ()


def compile_for_nodes(scenario: Scenario, tell: Callable[[str], None]) -> None:
    """
    Compile the functions of the nodes, if these will be forks of this process.

    This can take a minute; `tell` then gets a line for the user. It is not part of `fly`, so that Ctrl-C
    ends it at once.
    """
    if threads_allow_fork():
        compile_ahead(scenario, tell)


def fly(
    scenario: Scenario,
    *,
    mode: str,
    layout: str,
    results_dir: Path,
    with_bag: bool,
    domain_id: int,
    discovery: str,
    interrupts: Interrupts,
    progress: Progress,
) -> Flight:
    """
    Fly a scenario with ROS 2 nodes and return how it ended.

    Parameters
    ----------
    scenario : Scenario
        Resolved, sampled scenario.
    mode : str
        'lockstep' or 'realtime'.
    layout : str
        Grouping of nodes into processes, one of `layout.LAYOUTS`.
    results_dir : Path
        The run's folder, which gets `bag/` and `logs/`.
    with_bag : bool
        Whether a recorder runs.
    domain_id, discovery
        ROS domain held for this run, and 'localhost' or 'subnet'.
    interrupts : Interrupts
        An entered context; its count requests the end.
    progress : Progress
        Shows progress and messages.

    """
    bag_dir = results_dir / BAG if with_bag else None
    nodes = node_specs(scenario, mode=mode, bag_dir=bag_dir)
    environ = node_environment(os.environ, domain_id=domain_id, discovery=discovery)
    if mode == "lockstep":
        schedule_as_batch()
    clear_shared_memory()  # left by killed runs
    try:
        flight = fly_nodes(
            process_specs(nodes, layout),
            on_vehicle_loss=scenario.on_vehicle_loss,
            logs_dir=results_dir / LOGS,
            environ=environ,
            interrupts=interrupts,
            progress=progress,
        )
    finally:
        clear_shared_memory()
    return of_asked_length(flight, scenario, mode)


def of_asked_length(flight: Flight, scenario: Scenario, mode: str) -> Flight:
    """
    Return the flight, marked as failed if it is shorter than requested; in real time ticks may be missing.
    """
    more_s = 0.5 * scenario.period_s if mode == "lockstep" else scenario.answer_timeout_s
    over_s = flight.simulated_s - scenario.duration_s
    if flight.exit_status or -0.5 * scenario.period_s <= over_s <= more_s:
        return flight
    reason = f"the flight ended at {flight.simulated_s:.1f} s, not at the requested {scenario.duration_s:g} s"
    return replace(flight, exit_status=LOST_STATUS, reason=reason)


def start_process(
    children: ChildProcesses, process: ProcessSpec, parts: Sequence[Part], log: Path, environ: dict[str, str]
) -> None:
    """Start a node process, by a fork if possible."""
    if threads_allow_fork():
        children.fork(process.name, partial(_run_nodes, process.name, parts, environ), log=log)
    else:
        children.start(process.name, command_line(parts), log=log, environ=environ)


def fly_nodes(
    processes: Sequence[ProcessSpec],
    *,
    on_vehicle_loss: str,
    logs_dir: Path,
    environ: dict[str, str],
    interrupts: Interrupts,
    progress: Progress,
    start: Callable[
        [ChildProcesses, ProcessSpec, Sequence[Part], Path, dict[str, str]], None
    ] = start_process,
) -> Flight:
    """Start node processes, watch them until the flight is over, end them; `start` starts one."""
    params_dir = logs_dir / "params"
    params_dir.mkdir(parents=True, exist_ok=True)
    start_s = time.monotonic()
    _import_nodes(processes)
    with ChildProcesses() as children:
        for process in map(_launched, processes):
            log = logs_dir / f"{log_name(process.name)}.log"
            start(children, process, parts_of(process, params_dir), log, environ)
        supervisor = Supervisor([*processes, EAR], on_vehicle_loss=on_vehicle_loss)
        with StatusListener(children, environ, processes, logs_dir / f"{log_name(EAR.name)}.log") as listener:
            start_up_s = _watch(supervisor, children, listener, interrupts, progress, start_s)
            was_interrupted = interrupts.count > 0 and not supervisor.is_over
            if was_interrupted:
                progress.message("ending the run; press Ctrl-C again to hurry it")
            elif supervisor.reason:
                progress.message(f"{supervisor.reason}: ending the run")
            bag_is_closed = _end_in_order(processes, children, interrupts, progress, supervisor)
    flight = _flight(supervisor, was_interrupted, bag_is_closed, start_up_s)
    return replace(flight, strangers=(*listener.strangers, *listener.refused_writers))


def _launched(process: ProcessSpec) -> ProcessSpec:
    """Let the relay wait for the launcher's listener: a short flight could be over before it has started."""
    nodes = [
        replace(node, params={**node.params, "launched": True}) if node.role == "relay" else node
        for node in process.nodes
    ]
    return replace(process, nodes=tuple(nodes))


def _import_nodes(processes: Sequence[ProcessSpec]) -> None:
    """Import the modules of the forked processes once; this also shares their memory."""
    for module in sorted({node.module for process in processes for node in process.nodes}):
        import_module(module)
    for module in (CONTAINER_MODULE, EAR_MODULE):
        import_module(module)
    gc.collect()
    gc.freeze()


def _run_nodes(name: str, parts: Sequence[Part], environ: dict[str, str]) -> int:
    """Run as a node process."""
    from auv_bringup.nodes.node_container import run

    setproctitle(" ".join(command_line(parts)))  # needs the original environment
    setthreadtitle(log_name(name))
    adopt(environ)
    return run(parts)


def _watch(
    supervisor: Supervisor,
    children: ChildProcesses,
    listener: StatusListener,
    interrupts: Interrupts,
    progress: Progress,
    start_s: float,
) -> float:
    """Watch until the flight is over or interrupted; return the duration of the start (s; NaN: no start)."""
    start_up_s = math.nan
    last_s = looked_s = time.monotonic()
    wall = WallWatch(time.monotonic, time.time)
    while not supervisor.is_over and not interrupts.count:
        for status in listener.listen():
            supervisor.status_arrived(status, time.monotonic())
        for exit_ in children.collect_exits():
            log = children.log(exit_.name)
            supervisor.process_ended(exit_, last_lines(log), str(log))
        now_s = time.monotonic()
        if supervisor.has_begun:
            if math.isnan(start_up_s):
                start_up_s = now_s - start_s
                progress.message(f"all nodes are up after {start_up_s:.1f} s")
            progress.update(supervisor.simulated_s)
        supervisor.time_passed(min(now_s - last_s, _MOST_AWAKE_S))
        last_s = now_s
        if now_s - looked_s > _STOPPED_LOOK_S:
            supervisor.processes_stopped(children.stopped(), min(now_s - looked_s, 2.0 * _STOPPED_LOOK_S))
            looked_s = now_s
        for words in [wall.warning(), *listener.new_strangers(at_once=supervisor.is_over)]:
            if words:
                progress.message(f"warning: {words}")
        for line in supervisor.take_messages():
            progress.message(line if line.startswith(" ") else f"warning: {line}")
        children.kill(supervisor.take_processes_to_end())
    return start_up_s


def _end_in_order(
    processes: Sequence[ProcessSpec],
    children: ChildProcesses,
    interrupts: Interrupts,
    progress: Progress,
    supervisor: Supervisor,
) -> bool:
    """End all nodes, the recorder last; return whether every recorder closed its bag."""
    first = [process.name for process in processes if not process.records]
    recorders = [process.name for process in processes if process.records]
    longer_s = start_patience_s(vehicles_of(processes))
    end = partial(
        children.end,
        sigterm_after_s=LOST_HAND_OVER_S + longer_s if supervisor.exit_status == LOST_STATUS else None,
        is_hurried=lambda: interrupts.is_hurried,
    )
    exits = end(first, grace_s=SIGINT_GRACE_S + longer_s)
    recorder_exits = end(recorders, grace_s=RECORDER_GRACE_S + longer_s)
    killed = children.end_orphans(grace_s=RECORDER_GRACE_S, is_hurried=lambda: interrupts.is_hurried)
    if killed:
        progress.message("warning: the process that writes the bag did not end, and was killed")
    for exit_ in exits + recorder_exits:
        if exit_.returncode not in (0, LOST_STATUS) and exit_.name not in supervisor.stopped_processes:
            progress.message(
                f"warning: {exit_.name} did not end cleanly: {exit_.words}; "
                f"its log is {children.log(exit_.name)}"
            )
    return all(children.returncodes.get(name) == 0 for name in recorders)


def _flight(supervisor: Supervisor, was_interrupted: bool, bag_is_closed: bool, start_up_s: float) -> Flight:
    exit_status, reason = supervisor.exit_status, supervisor.reason
    if was_interrupted:
        exit_status, reason = INTERRUPTED_STATUS, f"interrupted at {supervisor.simulated_s:.1f} s"
    elif exit_status == 0 and not bag_is_closed:
        exit_status, reason = LOST_STATUS, "/recorder_node did not close its bag"
    return Flight(
        exit_status=exit_status,
        reason=reason,
        lost_vehicles=tuple(supervisor.lost_vehicles),
        simulated_s=supervisor.simulated_s,
        real_time_factor=supervisor.real_time_factor,
        start_up_s=start_up_s,
    )
