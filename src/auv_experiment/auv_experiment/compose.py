"""
The composition root: from a scenario to the configuration of every component, for one process and for ROS
nodes alike.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from auv_core.compiled import use_compiler
from auv_core.models import make_model
from auv_core.state_checks import LARGEST
from auv_experiment.scenario.schema import Scenario
from auv_flocking.agent import Agent
from auv_flocking.agent_config import AgentConfig
from auv_flocking.input_limits import InputLimits
from auv_sim.streams import Purpose, uniform
from auv_sim.vehicle import Vehicle, VehicleConfig

_SPEED_MARGIN = 10.0


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
    held_mps = max(make_model(vehicle.model).top_speed_mps for vehicle in scenario.vehicles)
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
