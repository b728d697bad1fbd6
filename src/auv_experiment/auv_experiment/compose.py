"""
The composition root: it derives the configuration of every component from a scenario, for in-process runs
and for ROS nodes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from auv_core.compiled import use_compiler
from auv_core.models import make_model, thrusters_of
from auv_core.params import extended
from auv_core.state_checks import LARGEST
from auv_experiment.scenario.reach import water_speed_mps
from auv_experiment.scenario.schema import Scenario, VehicleEntry
from auv_experiment.scenario.task_checks import channel_cycle_s
from auv_experiment.scenario.teams import distinct_agents, is_group, teams
from auv_flocking.agent import Agent
from auv_flocking.agent_config import AgentConfig, AgentSettings, SpokenReport
from auv_flocking.input_limits import InputLimits
from auv_flocking.neighbours.filter import NeighbourConfig
from auv_sim.acoustics.medium import NO_SONAR
from auv_sim.navigation import make_navigation
from auv_sim.streams import Purpose, uniform
from auv_sim.vehicle import Vehicle, VehicleConfig

_SPEED_MARGIN = 10.0


def vehicle_configs(scenario: Scenario) -> list[VehicleConfig]:
    """Return the configuration of every simulated vehicle, in the order of addresses."""
    return [
        extended(
            VehicleConfig,
            vehicle,
            scenario.environment,
            scenario,
            vehicle_id=vehicle.id,
            position_ned_m=vehicle.position_ned_m or (0.0, 0.0, 0.0),
            address=index + 1,
        )
        for index, vehicle in enumerate(scenario.vehicles)
    ]


def agent_configs(scenario: Scenario) -> list[AgentConfig]:
    """Return the configuration of every agent, in the order of addresses."""
    obstacles = [obstacle for obstacle in scenario.environment.obstacles if obstacle.known]
    fleet_ids = tuple(vehicle.id for vehicle in scenario.vehicles)
    spoken = _spoken_reports(scenario)
    groups, planned, cycle_s = _groups(scenario), _planned(scenario), channel_cycle_s(scenario)
    settings: dict[int, AgentSettings] = {}
    for software in distinct_agents(scenario):
        limited = replace(
            software.agent,
            inputs=input_limits(scenario, software.agent.inputs),
            neighbours=neighbour_settings(scenario, software.agent.neighbours),
        )
        settings |= dict.fromkeys(software.vehicles, limited)
    return [
        extended(
            AgentConfig,
            settings[index],
            scenario,
            vehicle_id=vehicle.id,
            address=index + 1,
            fleet_size=len(scenario.vehicles),
            fleet_ids=fleet_ids,
            group=groups[index],
            heard_reports=tuple(each for each in spoken if each.report != settings[index].report),
            is_leader=vehicle.id in scenario.leaders,
            fails_at_s=vehicle.fails_at_s,
            has_sonar=scenario.acoustics.sonar.kind != NO_SONAR.kind,
            obstacles_ned_m=tuple(x for obstacle in obstacles for x in obstacle.position_ned_m),
            obstacle_safety_distances_m=tuple(obstacle.safety_distance_m for obstacle in obstacles),
            reference=scenario.reference_section(index),
            thrusters=thrusters_of(vehicle.model),
            fault=vehicle.fault,
            cycle_s=cycle_s,
            starts_ned_m=tuple(x for start in planned[index] for x in start.position_ned_m or ()),
            start_headings_rad=tuple(start.heading_rad for start in planned[index]),
            start_speeds_mps=tuple(start.speed_mps for start in planned[index]),
        )
        for index, vehicle in enumerate(scenario.vehicles)
    ]


def _spoken_reports(scenario: Scenario) -> list[SpokenReport]:
    """Return what vehicles speak, one of each kind; a check of the scenario has seen that kinds are alike."""
    spoken = {
        software.agent.report.kind: SpokenReport.of(software.agent) for software in distinct_agents(scenario)
    }
    return list(spoken.values())


def _groups(scenario: Scenario) -> dict[int, tuple[int, ...]]:
    """Return the addresses of each vehicle's group; empty if that is all vehicles, or there is no group."""
    groups: dict[int, tuple[int, ...]] = {}
    for indices in teams(scenario):
        is_part = len(indices) < len(scenario.vehicles) and is_group(scenario.agents[indices[0]])
        groups |= dict.fromkeys(indices, tuple(index + 1 for index in indices) if is_part else ())
    return groups


def _planned(scenario: Scenario) -> dict[int, list[VehicleEntry]]:
    """Return the vehicles of which each vehicle knows the start: those of its fleet."""
    planned: dict[int, list[VehicleEntry]] = {}
    for indices in teams(scenario):
        is_fleet = scenario.agents[indices[0]].fleet is not None
        mates = [scenario.vehicles[index] for index in indices] if is_fleet else []
        planned |= dict.fromkeys(indices, mates)
    return planned


def input_limits(scenario: Scenario, limits: InputLimits) -> InputLimits:
    """Return the input limits of an agent; a missing speed limit follows from the vehicles."""
    if limits.speed_max_mps is not None:
        return limits
    held_mps = max(make_model(vehicle.model).top_speed_mps for vehicle in scenario.vehicles)
    fastest_mps = held_mps + water_speed_mps(scenario)
    return replace(limits, speed_max_mps=min(_SPEED_MARGIN * fastest_mps, LARGEST))


def neighbour_settings(scenario: Scenario, settings: NeighbourConfig) -> NeighbourConfig:
    """
    Return the settings of an agent's neighbour filters; the noise of reports includes the white noise of the
    navigation that the vehicles carry.
    """
    navigation = make_navigation(scenario.environment.navigation, scenario.seed, 1, scenario.period_s)
    return replace(
        settings,
        position_std_m=math.hypot(settings.position_std_m, navigation.depth_sd_m),
        velocity_std_mps=math.hypot(settings.velocity_std_mps, max(navigation.velocity_sd_mps)),
    )


def compile_ahead(scenario: Scenario, tell: Callable[[str], None]) -> None:
    """
    Compile the functions that a scenario's vehicles, agents and modems call, so that forked processes have
    them; `tell` gets a line for the user if this takes long.
    """
    use_compiler(tell)
    for vehicle, agent in zip(vehicle_configs(scenario), agent_configs(scenario), strict=True):
        Vehicle(vehicle)
        Agent(agent)
    uniform(scenario.seed, Purpose.OUTAGE, 1, 2, 1)
