"""
Fly a scenario with `ros2 launch`: the nodes of `./scripts/run`, started the ROS 2 way.

    ros2 launch auv_bringup flock.launch.py
    ros2 launch auv_bringup flock.launch.py scenario:=flock_acoustic seed:=7 mode:=realtime
    ros2 launch auv_bringup flock.launch.py layout:=vehicle
    ros2 launch auv_bringup flock.launch.py set:='acoustics.outage.params.loss_prob=0.5; duration_s=60'

It takes a ROS domain as `./scripts/run` does: $ROS_DOMAIN_ID, or the next one that no other run uses. It
makes the same results folder, with the scenario, the bag, the logs of the nodes, metrics, figures and report,
and then ends. `ros2 launch` has only the statuses 0 and 1: 1 means that the flight was lost, that hulls
touched, or that there is no report. The status that `./scripts/run` would give is `exit_status` in
provenance.json: 0, 3, 4, or 130 after Ctrl-C.
"""

import os
import sys
from collections.abc import Mapping
from pathlib import Path

from launch import Action, LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    ExecuteProcess,
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
    SetEnvironmentVariable,
    UnsetEnvironmentVariable,
)
from launch.event_handlers import OnProcessExit, OnProcessIO, OnShutdown
from launch.events import Shutdown, matches_action
from launch.events.process import ProcessExited, ProcessIO, ShutdownProcess
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from auv_bringup.launching.domains import DomainClaim, claim_domain
from auv_bringup.launching.layout import DEFAULT_LAYOUT, LAYOUTS, ProcessSpec, process_specs
from auv_bringup.launching.node_specs import NodeSpec, node_specs
from auv_bringup.launching.node_start import (
    container_arguments,
    export_line,
    log_name,
    node_environment,
    parts_of,
    reach_notes,
    write_params_file,
)
from auv_bringup.launching.plan import DEFAULT_SCENARIO, ROS_MODES, Plan, make_plan, start_results
from auv_bringup.launching.shared_memory import clear_shared_memory
from auv_bringup.launching.verdict import LOST, verdict
from auv_core.cli.failures import DONE, INTERRUPTED
from auv_core.params import ConfigError
from auv_experiment import results

# Nodes deliver their last messages and the recorder closes the bag: launch's own 5 s could be too short.
TIME_TO_LEAVE = {"sigterm_timeout": "30", "sigkill_timeout": "30"}


class BadEndError(RuntimeError):
    """Raised if a flight did not end well: only an exception makes launch end with a status other than 0."""


def generate_launch_description() -> LaunchDescription:
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "scenario",
                default_value=DEFAULT_SCENARIO,
                description="name of a scenario, or path of a YAML file",
            ),
            DeclareLaunchArgument(
                "mode", default_value="lockstep", choices=list(ROS_MODES), description="how time passes"
            ),
            DeclareLaunchArgument(
                "layout",
                default_value=DEFAULT_LAYOUT,
                choices=list(LAYOUTS),
                description="how nodes are grouped into processes",
            ),
            DeclareLaunchArgument("seed", default_value="", description="seed; empty: the scenario's"),
            DeclareLaunchArgument(
                "set", default_value="", description="overrides, path.to.key=value, separated by semicolons"
            ),
            DeclareLaunchArgument(
                "bag", default_value="true", choices=["true", "false"], description="record a bag"
            ),
            DeclareLaunchArgument("out", default_value="results", description="folder of the results"),
            DeclareLaunchArgument(
                "discovery",
                default_value="localhost",
                choices=["localhost", "subnet"],
                description="which machines can see the nodes: this one, or its network",
            ),
            OpaqueFunction(function=start_flight),
        ]
    )


def start_flight(context: LaunchContext) -> list[Action]:
    """Return the actions that start, watch and end a flight."""
    given = {
        name: LaunchConfiguration(name).perform(context).strip()
        for name in ("scenario", "mode", "layout", "seed", "set", "bag", "out", "discovery")
    }
    plan = make_plan(
        given["scenario"],
        mode=given["mode"],
        layout=given["layout"],
        seed=seed_of(given["seed"]),
        overrides=[part.strip() for part in given["set"].split(";") if part.strip()],
        discovery=given["discovery"],
    )
    # Never released: the nodes need it until launch ends, and the kernel releases it with this process.
    claim = claim_domain(os.environ)
    folder = start_results(plan, Path(given["out"])).resolve()
    params_dir = folder / results.LOGS / "params"
    params_dir.mkdir()
    specs = node_specs(
        plan.scenario,
        mode=plan.mode,
        bag_dir=folder / results.BAG if given["bag"] == "true" else None,
    )
    clear_shared_memory()  # left by killed runs
    processes = {
        process_action(process, params_dir): process for process in process_specs(specs, plan.layout)
    }
    ending = Ending(processes, plan, folder, has_bag=given["bag"] == "true", domain_id=claim.domain_id)
    return [
        LogInfo(msg=f"{plan.scenario.name}: {plan.scenario.title}; results go to {folder}"),
        *domain_notes(claim, given["discovery"]),
        *environment_actions(claim.domain_id, given["discovery"]),
        RegisterEventHandler(log_handler(processes, folder)),
        RegisterEventHandler(OnProcessExit(on_exit=ending.process_ended)),
        RegisterEventHandler(OnShutdown(on_shutdown=ending.shut_down)),
        *processes,
    ]


def log_of(process: ProcessSpec, folder: Path) -> Path:
    """Return the log of a process in a folder of results."""
    return folder / results.LOGS / f"{log_name(process.name)}.log"


def log_handler(processes: Mapping[Node, ProcessSpec], folder: Path) -> OnProcessIO:
    """Return the handlers that write the output of each process to its log."""

    def write(event: ProcessIO) -> None:
        if event.action in processes:
            with log_of(processes[event.action], folder).open("ab") as log:
                log.write(event.text)

    return OnProcessIO(on_stdout=write, on_stderr=write)


def seed_of(text: str) -> int | None:
    """Return the seed in the argument, None if it is empty."""
    if not text:
        return None
    if not (text.isascii() and text.isdecimal()):
        raise ConfigError(f"seed:={text} is not allowed; allowed: a whole number of at least 0")
    return int(text)


def domain_notes(claim: DomainClaim, discovery: str) -> list[Action]:
    """Return the actions that print the domain of the nodes and how to inspect them."""
    notes = [LogInfo(msg=f"to inspect it from another shell:  {export_line(claim.domain_id, discovery)}")]
    if claim.is_moved:
        moved = (
            f"ROS domain {claim.asked_id} is in use by another run; this one takes domain {claim.domain_id}"
        )
        notes.insert(0, LogInfo(msg=moved))
    return [*(LogInfo(msg=line) for line in reach_notes(os.environ, discovery)), *notes]


def environment_actions(domain_id: int, discovery: str) -> list[Action]:
    """Return the actions that set the nodes' environment as `./scripts/run` does."""
    wanted = node_environment(os.environ, domain_id=domain_id, discovery=discovery)
    unwanted = sorted(set(os.environ) - set(wanted))
    changed = sorted(name for name in wanted if os.environ.get(name) != wanted[name])
    return [
        *(UnsetEnvironmentVariable(name) for name in unwanted),
        *(SetEnvironmentVariable(name, wanted[name]) for name in changed),
    ]


def process_action(process: ProcessSpec, params_dir: Path) -> Node:
    """Return the action that starts a process: a single node, or a container of several."""
    if len(process.nodes) == 1:
        return node_action(process.nodes[0], write_params_file(process.nodes[0], params_dir))
    return Node(
        package="auv_bringup",
        executable="node_container",
        arguments=container_arguments(parts_of(process, params_dir)),
        output="screen",
        **TIME_TO_LEAVE,
    )


def node_action(spec: NodeSpec, params_file: Path) -> Node:
    """Return the action that starts a node."""
    options = dict(TIME_TO_LEAVE)
    if spec.role != "relay":  # its process holds two nodes, and a name given here would go to both
        options["name"] = spec.name.rsplit("/", 1)[1]
    return Node(
        package=spec.package,
        executable=spec.executable,
        namespace=spec.namespace,
        parameters=[str(params_file)],
        output="screen",
        **options,
    )


class Ending:
    """
    Ends a flight step by step.

    It starts when the relay, which holds the clock, or the recorder ends. Then relay, vehicles and agents
    are ended, then the recorder, then the report is made, and launch shuts down. The provenance records how
    the flight ended.

    Parameters
    ----------
    processes : mapping
        The processes of the flight, by action.
    plan : Plan
        The plan of the flight.
    folder : Path
        Folder of the results.
    has_bag : bool
        Whether there will be a bag for a report.
    domain_id : int
        ROS domain of the flight.

    """

    def __init__(
        self,
        processes: Mapping[Node, ProcessSpec],
        plan: Plan,
        folder: Path,
        *,
        has_bag: bool,
        domain_id: int,
    ) -> None:
        self._plan = plan
        self._domain_id = domain_id
        self._running = dict(processes)
        self._told: set[Node] = set()
        self._folder = folder
        self._has_begun = False
        self._status, self._fault = DONE, ""
        self._report = (
            ExecuteProcess(
                cmd=[sys.executable, "-m", "auv_bringup.tools.run", "--report", str(folder)],
                name="report",
                output="screen",
            )
            if has_bag
            else None
        )
        self._last_line = (
            f"to make the report:  ros2 run auv_bringup run --report {folder}"
            if has_bag
            else f"no bag, so no report; logs are in {folder / results.LOGS}"
        )

    def process_ended(self, event: ProcessExited, context: LaunchContext) -> list[Action]:
        """
        Handle the end of a process; return the next actions.

        Raises
        ------
        BadEndError
            At the end of a flight that failed.

        """
        if event.action is self._report:
            return self._report_ended(event.returncode)
        if event.action not in self._running:
            return []
        process = self._running.pop(event.action)
        if context.is_shutdown and not self._has_begun:
            self._status, self._fault = INTERRUPTED, "interrupted"
        else:
            self._judge(process, event.returncode)
        if not self._running:
            self._remember()
        if context.is_shutdown:  # launch has signalled every process and starts no more
            return [] if self._running else [LogInfo(msg=self._last_line)]
        return self._next() if self._has_begun else []

    def shut_down(self, _event: Shutdown, _context: LaunchContext) -> list[Action]:
        """Print where the report is, once no process is running."""
        return [] if self._running else [LogInfo(msg=self._last_line)]

    def _judge(self, process: ProcessSpec, returncode: int) -> None:
        """Begin the end of the flight, and declare it lost, if the end of this process means that."""
        if process.role not in ("relay", "recorder"):
            return  # the clock notices this and goes on without the vehicle or ends the flight
        too_early = process.role == "recorder" and not self._has_begun
        if (returncode != 0 or too_early) and not self._fault:
            log = log_of(process, self._folder)
            self._status = LOST
            self._fault = (
                f"the flight is lost: {process.name} has ended with status {returncode}; its log is {log}"
            )
        self._has_begun = True

    def _next(self) -> list[Action]:
        """Return the actions that end the next processes: the recorder ends last, then the report is made."""
        flying = [action for action, process in self._running.items() if process.role != "recorder"]
        leaving = flying or list(self._running)
        if leaving:
            untold = [action for action in leaving if action not in self._told]
            self._told.update(untold)
            return [
                EmitEvent(event=ShutdownProcess(process_matcher=matches_action(action))) for action in untold
            ]
        return [self._report] if self._report is not None else self._finish()

    def _remember(self) -> None:
        """Record how the flight ended, and remove leftovers of dead processes."""
        clear_shared_memory()
        results.write_ending(
            self._folder,
            domain_id=self._domain_id,
            exit_status=self._status,
            stopped_because=self._fault or None,
        )

    def _report_ended(self, returncode: int) -> list[Action]:
        if returncode != 0:
            self._fault = self._fault or f"the report could not be made (status {returncode})"
            return self._finish()
        self._last_line = f"report: {self._folder / results.REPORT_FILE}"
        if self._status == DONE:
            metrics = results.read_json(self._folder / results.METRICS_FILE)
            self._status, self._fault = verdict(metrics, self._plan.scenario, self._plan.mode)
            if self._status != DONE:
                results.write_ending(self._folder, exit_status=self._status)
        return self._finish()

    def _finish(self) -> list[Action]:
        if self._fault:
            raise BadEndError(self._fault)
        return [EmitEvent(event=Shutdown(reason="the flight is over"))]
