"""Checks that vehicles can fly their course, or their part in a fleet, in the current."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from auv_control.controllers import make_controller
from auv_control.courses import make_course
from auv_core.models import make_model
from auv_flocking.fleets import FleetTask, Mission, make_fleet
from auv_flocking.flocking import Member
from auv_sim.acoustics.mac import CyclicAccess, make_mac

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


def channel_cycle_s(scenario: Scenario) -> float | None:
    """Return the time between two turns of a modem (s), None if the medium access has no cycle."""
    mac = make_mac(scenario.acoustics.mac, len(scenario.vehicles), scenario.seed)
    return mac.cycle_s if isinstance(mac, CyclicAccess) else None


def check_tasks(scenario: Scenario, water_mps: float) -> None:
    """
    Check that vehicles hold the speed of their course or lane, and can turn as its path turns.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    water_mps : float
        Speed that the current seldom exceeds (m/s).

    Raises
    ------
    ValueError
        At the first vehicle that cannot; the message begins with the field.

    """
    agent = scenario.agent
    for index, vehicle in enumerate(scenario.vehicles):
        if agent.course is not None:
            try:
                make_course(agent.course, scenario.period_s).check(make_model(vehicle.model), water_mps)
            except ValueError as error:
                raise ValueError(f"agent.course.params.{error}, for vehicles[{index}]") from None
        if agent.fleet is not None:
            try:
                fleet_task(scenario, index).check(make_model(vehicle.model), water_mps)
            except ValueError as error:
                raise ValueError(f"agent.fleet.params.{error}, for vehicles[{index}]") from None


def fleet_task(scenario: Scenario, index: int) -> FleetTask:
    """Return the task of a vehicle in the fleet of a scenario that has one."""
    agent = scenario.agent
    assert agent.fleet is not None
    controller: Any = make_controller(agent.controller, scenario.period_s)
    member = Member(False, index + 1, len(scenario.vehicles))
    mission = Mission(cycle_s=channel_cycle_s(scenario))
    return make_fleet(agent.fleet, member, controller, scenario.period_s, mission)
