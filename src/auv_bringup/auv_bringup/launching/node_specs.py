"""The nodes of a scenario's run: modules, names and parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from auv_bringup.launching.layout import patience_s, start_patience_s
from auv_core.params import dump, extended, item_key
from auv_experiment.compose import agent_configs, vehicle_configs
from auv_experiment.scenario.schema import Scenario
from auv_sim.obstacle_field import ObstacleConfig

START_TIMEOUT_S = 60.0


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
        Folder of the bag; without it there is no recorder.

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
    if scenario.environment.obstacles:
        params["obstacle_count"] = len(scenario.environment.obstacles)
        params["obstacles"] = {
            f"o{number}": _plain(extended(ObstacleConfig, obstacle))
            for number, obstacle in enumerate(scenario.environment.obstacles)
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
        module="auv_bag.nodes.recorder_node",
        package="auv_bag",
        executable="recorder_node",
        namespace="/",
        role="recorder",
        vehicle_id="",
        params={
            "bag_dir": str(bag_dir),
            "topics_vehicles": [vehicle.id for vehicle in scenario.vehicles],
            "commands": list(scenario.commands),
            "mode": mode,
        },
    )


def _plain(config: object) -> dict[str, Any]:
    """
    Return a configuration as nested ROS parameters without empty lists, which have no type in ROS.

    Lists of configurations become mappings.
    """
    plain: dict[str, Any] = _without_empty(dump(config))
    return plain


def _without_empty(value: Any) -> Any:
    if isinstance(value, list) and value and isinstance(value[0], dict):
        value = {item_key(index): item for index, item in enumerate(value)}
    if not isinstance(value, dict):
        return value
    kept = {key: _without_empty(item) for key, item in value.items()}
    return {key: item for key, item in kept.items() if item not in (None, [], {})}
