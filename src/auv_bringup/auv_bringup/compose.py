"""
The composition root: from a scenario to the configuration of every component, for one process and for ROS
nodes alike.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from auv_bringup.layout import patience_s, start_patience_s
from auv_bringup.scenario import Scenario
from auv_core.compiled import use_compiler
from auv_core.params import dump
from auv_core.plugins import find_plugin
from auv_core.state_checks import LARGEST
from auv_flocking.agent import Agent, AgentConfig
from auv_flocking.input_limits import InputLimits
from auv_sim.streams import Purpose, uniform
from auv_sim.vehicle import MODELS, Vehicle, VehicleConfig

START_TIMEOUT_S = 60.0
_SPEED_MARGIN = 10.0


@dataclass(frozen=True)
class NodeSpec:
    """
    One node to start.

    `name` is the full node name, `params` its ROS parameters as nested plain values; `role` is vehicle,
    agent, relay or recorder.
    """

    name: str
    module: str
    package: str
    executable: str
    namespace: str
    role: str
    vehicle_id: str
    params: dict[str, Any]


def vehicle_configs(scenario: Scenario) -> list[VehicleConfig]:
    """Return the configuration of every simulated vehicle, in the order of addresses."""
    return [
        VehicleConfig(
            vehicle_id=vehicle.id,
            model=vehicle.model,
            position_ned_m=vehicle.position_ned_m or (0.0, 0.0, 0.0),
            heading_rad=vehicle.heading_rad,
            current_ned_mps=scenario.environment.current_ned_mps,
            dt_s=scenario.dt_s,
            period_s=scenario.period_s,
            address=index + 1,
            seed=scenario.seed,
            navigation=scenario.environment.navigation,
            command_max_age_s=scenario.command_max_age_s,
        )
        for index, vehicle in enumerate(scenario.vehicles)
    ]


def agent_configs(scenario: Scenario) -> list[AgentConfig]:
    """Return the configuration of every agent, in the order of addresses."""
    obstacles = scenario.environment.obstacles
    settings = scenario.agent
    fleet_ids = tuple(vehicle.id for vehicle in scenario.vehicles)
    limits = input_limits(scenario)
    return [
        AgentConfig(
            vehicle_id=vehicle.id,
            address=index + 1,
            fleet_size=len(scenario.vehicles),
            fleet_ids=fleet_ids,
            is_leader=vehicle.id in scenario.leaders,
            period_s=scenario.period_s,
            hold_s=settings.hold_s,
            obstacles_ned_m=tuple(x for obstacle in obstacles for x in obstacle.position_ned_m),
            obstacle_safety_distances_m=tuple(obstacle.safety_distance_m for obstacle in obstacles),
            reference=scenario.reference if vehicle.reference is None else vehicle.reference,
            flocking=settings.flocking,
            separation=settings.separation,
            consensus=settings.consensus,
            report=settings.report,
            neighbours=settings.neighbours,
            inputs=limits,
            controller=settings.controller,
        )
        for index, vehicle in enumerate(scenario.vehicles)
    ]


def input_limits(scenario: Scenario) -> InputLimits:
    """Return what agents take for too old or impossible; a speed limit left out follows from the vehicles."""
    limits = scenario.agent.inputs
    if limits.speed_max_mps is not None:
        return limits
    held_mps = max(
        find_plugin(MODELS, vehicle.model.kind).Model(vehicle.model.params).top_speed_mps
        for vehicle in scenario.vehicles
    )
    fastest_mps = held_mps + math.hypot(*scenario.environment.current_ned_mps)
    return replace(limits, speed_max_mps=min(_SPEED_MARGIN * fastest_mps, LARGEST))


def compile_ahead(scenario: Scenario, tell: Callable[[str], None]) -> None:
    """
    Compile what the vehicles, agents and modems of a scenario call, so that processes forked from this one
    have it; `tell` gets a line for the user where that takes a while.
    """
    use_compiler(tell)
    for vehicle, agent in zip(vehicle_configs(scenario), agent_configs(scenario), strict=True):
        Vehicle(vehicle)
        Agent(agent)
    uniform(scenario.seed, Purpose.OUTAGE, 1, 2, 1)


def node_specs(scenario: Scenario, *, mode: str, bag_dir: Path | None) -> list[NodeSpec]:
    """
    Return every node of a run.

    Parameters
    ----------
    scenario : Scenario
        Resolved scenario.
    mode : str
        ``lockstep`` or ``realtime``.
    bag_dir : Path, optional
        Where the recorder writes; without it there is no recorder.

    """
    run = {"mode": mode, "recorded": bag_dir is not None}
    specs = [_relay_spec(scenario, run)]
    for vehicle, agent in zip(vehicle_configs(scenario), agent_configs(scenario), strict=True):
        specs.append(_vehicle_spec("vehicle", "auv_sim", vehicle.vehicle_id, {**run, **_plain(vehicle)}))
        specs.append(_vehicle_spec("agent", "auv_flocking", agent.vehicle_id, {**run, **_plain(agent)}))
    if bag_dir is not None:
        specs.append(_recorder_spec(scenario, mode, bag_dir))
    return specs


def _vehicle_spec(role: str, package: str, vehicle_id: str, params: dict[str, Any]) -> NodeSpec:
    executable = f"{role}_node"
    return NodeSpec(
        name=f"/{vehicle_id}/{executable}",
        module=f"{package}.nodes.{executable}",
        package=package,
        executable=executable,
        namespace=f"/{vehicle_id}",
        role=role,
        vehicle_id=vehicle_id,
        params=params,
    )


def _relay_spec(scenario: Scenario, run: Mapping[str, Any]) -> NodeSpec:
    params = {
        **run,
        **_plain(scenario.medium_config),
        "vehicle_ids": [vehicle.id for vehicle in scenario.vehicles],
        "duration_ticks": scenario.ticks,
        "on_vehicle_loss": scenario.on_vehicle_loss,
        "state_max_age_s": scenario.state_max_age_s,
        "answer_timeout_s": scenario.answer_timeout_s + patience_s(len(scenario.vehicles)),
        "start_timeout_s": START_TIMEOUT_S + start_patience_s(len(scenario.vehicles)),
    }
    if scenario.on_vehicle_loss == "continue":
        params["hulls"] = {config.vehicle_id: _plain(config) for config in vehicle_configs(scenario)}
    return NodeSpec(
        name="/acoustic_relay_node",
        module="auv_sim.nodes.acoustic_relay_node",
        package="auv_sim",
        executable="acoustic_relay_node",
        namespace="/",
        role="relay",
        vehicle_id="",
        params=params,
    )


def _recorder_spec(scenario: Scenario, mode: str, bag_dir: Path) -> NodeSpec:
    return NodeSpec(
        name="/recorder_node",
        module="auv_bringup.nodes.recorder_node",
        package="auv_bringup",
        executable="recorder_node",
        namespace="/",
        role="recorder",
        vehicle_id="",
        params={
            "bag_dir": str(bag_dir),
            "topics_vehicles": [vehicle.id for vehicle in scenario.vehicles],
            "kinematic": scenario.kinematic,
            "mode": mode,
        },
    )


def _plain(config: object) -> dict[str, Any]:
    """
    Return a configuration as nested ROS parameters: nothing empty, since an empty list has no type in ROS.
    """
    plain: dict[str, Any] = _without_empty(dump(config))
    return plain


def _without_empty(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    kept = {key: _without_empty(item) for key, item in value.items()}
    return {key: item for key, item in kept.items() if item not in (None, [], {})}
