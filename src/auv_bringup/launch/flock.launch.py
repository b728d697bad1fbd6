"""
Fly a scenario with `ros2 launch`: the nodes of `./scripts/run`, started the ROS 2 way.

    ros2 launch auv_bringup flock.launch.py
    ros2 launch auv_bringup flock.launch.py scenario:=flock_acoustic seed:=7 mode:=realtime
    ros2 launch auv_bringup flock.launch.py layout:=vehicle
    ros2 launch auv_bringup flock.launch.py set:='acoustics.outage.params.loss_prob=0.5; duration_s=60'

It takes a ROS domain as `./scripts/run` does: $ROS_DOMAIN_ID, or the next that no other run holds.
It makes the same results folder, with the scenario and the bag, and ends by itself when the flight is over.
Metrics, figures and report are then made by `ros2 run auv_bringup run --report FOLDER`.
"""

import os
from pathlib import Path

from launch import Action, LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
    SetEnvironmentVariable,
    UnsetEnvironmentVariable,
)
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown, matches_action
from launch.events.process import ProcessExited, ShutdownProcess
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from auv_bringup import results
from auv_bringup.compose import NodeSpec, node_specs
from auv_bringup.domains import DomainClaim, claim_domain
from auv_bringup.layout import DEFAULT_LAYOUT, LAYOUTS, ProcessSpec, process_specs
from auv_bringup.node_start import (
    container_arguments,
    export_line,
    node_environment,
    parts_of,
    write_params_file,
)
from auv_bringup.plan import DEFAULT_SCENARIO, ROS_MODES, make_plan, start_results
from auv_core.params import ConfigError

# The recorder drains what is still under way before it closes the bag; launch's own 5 s could be too short.
RECORDER_GRACE_S = "30"


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
                description="which nodes share a process",
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
                description="who may see the nodes: this machine only, or its network",
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
    # Never released: the nodes need it until launch ends, and the kernel drops it with this process.
    claim = claim_domain(os.environ)
    folder = start_results(plan, Path(given["out"])).resolve()
    params_dir = folder / results.LOGS / "params"
    params_dir.mkdir()
    specs = node_specs(
        plan.scenario,
        mode=plan.mode,
        bag_dir=folder / results.BAG if given["bag"] == "true" else None,
    )
    actions = {role: [] for role in ("relay", "vehicle", "agent", "recorder")}
    for process in process_specs(specs, plan.layout):
        actions[process.role].append(process_action(process, params_dir))
    nodes = [action for group in actions.values() for action in group]
    ending = Ending(
        relays=actions["relay"],
        others=[*actions["vehicle"], *actions["agent"]],
        recorders=actions["recorder"],
    )
    return [
        LogInfo(msg=f"{plan.scenario.name}: {plan.scenario.title}; results go to {folder}"),
        *domain_notes(claim, given["discovery"]),
        *environment_actions(claim.domain_id, given["discovery"]),
        RegisterEventHandler(OnProcessExit(on_exit=ending.process_ended)),
        *nodes,
    ]


def seed_of(text: str) -> int | None:
    """Return the seed that the argument asks for, None where it is empty."""
    if not text:
        return None
    if not (text.isascii() and text.isdecimal()):
        raise ConfigError(f"seed:={text} is not allowed; allowed: a whole number of at least 0")
    return int(text)


def domain_notes(claim: DomainClaim, discovery: str) -> list[Action]:
    """Return the actions that say in which domain the nodes are, and how to look in."""
    notes = [LogInfo(msg=f"to look in from another shell:  {export_line(claim.domain_id, discovery)}")]
    if claim.is_moved:
        moved = (
            f"ROS domain {claim.asked_id} is in use by another run; this one takes domain {claim.domain_id}"
        )
        notes.insert(0, LogInfo(msg=moved))
    return notes


def environment_actions(domain_id: int, discovery: str) -> list[Action]:
    """Return the actions that give the nodes the environment that `./scripts/run` gives them."""
    wanted = node_environment(os.environ, domain_id=domain_id, discovery=discovery)
    unwanted = sorted(set(os.environ) - set(wanted))
    changed = sorted(name for name in wanted if os.environ.get(name) != wanted[name])
    return [
        *(UnsetEnvironmentVariable(name) for name in unwanted),
        *(SetEnvironmentVariable(name, wanted[name]) for name in changed),
    ]


def process_action(process: ProcessSpec, params_dir: Path) -> Node:
    """Return the action that starts a process: a node by itself, or a container of several."""
    if len(process.nodes) == 1:
        return node_action(process.nodes[0], write_params_file(process.nodes[0], params_dir))
    return Node(
        package="auv_bringup",
        executable="node_container",
        arguments=container_arguments(parts_of(process, params_dir)),
        output="screen",
        **({"sigterm_timeout": RECORDER_GRACE_S} if process.records else {}),
    )


def node_action(spec: NodeSpec, params_file: Path) -> Node:
    """Return the action that starts a node."""
    options = {}
    if spec.role != "relay":  # its process holds two nodes, and a name given here would go to both
        options["name"] = spec.name.rsplit("/", 1)[1]
    if spec.role == "recorder":
        options["sigterm_timeout"] = RECORDER_GRACE_S
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
    Ends a flight in order.

    When the relay, which holds the clock, has ended: vehicles and agents; after them the recorder. The end of
    the recorder ends everything, too.
    """

    def __init__(self, *, relays: list[Node], others: list[Node], recorders: list[Node]) -> None:
        self._relays = relays
        self._others = list(others)
        self._recorders = recorders
        self._has_begun = False

    def process_ended(self, event: ProcessExited, context: LaunchContext) -> list[Action]:
        """Take the end of any process; return what to do about it."""
        if event.action in self._others:
            self._others.remove(event.action)
        if event.action in self._recorders:
            return [self._shut_down("the recorder has ended")]
        if event.action in self._relays:
            self._has_begun = True
            if self._others:
                return [
                    EmitEvent(event=ShutdownProcess(process_matcher=matches_action(action)))
                    for action in self._others
                ]
        if self._has_begun and not self._others:
            return [self._shut_down("the flight is over")]
        return []

    @staticmethod
    def _shut_down(reason: str) -> Action:
        return EmitEvent(event=Shutdown(reason=reason))
