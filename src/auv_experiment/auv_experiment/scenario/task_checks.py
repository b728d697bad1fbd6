"""Checks that vehicles can fly their course, or their part in a fleet, in the current."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from auv_control.controllers import make_controller
from auv_control.courses import make_course
from auv_control.guidance.feasibility import Turning
from auv_core.models import make_model
from auv_experiment.scenario.teams import distinct_agents, team_of
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
    for key, agent, indices in distinct_agents(scenario):
        if agent.course is not None:
            course = make_course(agent.course, scenario.period_s)
            for index in indices:
                _check(course.check, scenario, index, water_mps, f"{key}.course.params")
        if agent.fleet is not None:
            for index in indices:
                where = f"{key}.fleet.params"
                try:
                    task = fleet_task(scenario, index)
                except ValueError as error:
                    raise ValueError(f"{where}.{error}, for vehicles[{index}]") from None
                _check(task.check, scenario, index, water_mps, where)


def fleet_task(scenario: Scenario, index: int) -> FleetTask:
    """Return the task of a vehicle that is in a fleet."""
    agent, mates = scenario.agents[index], team_of(scenario, index)
    assert agent.fleet is not None
    controller: Any = make_controller(agent.controller, scenario.period_s)
    member = Member(False, 1 + mates.index(index), len(mates))
    mission = Mission(cycle_s=channel_cycle_s(scenario))
    return make_fleet(agent.fleet, member, controller, scenario.period_s, mission)


def _check(
    check: Callable[[Turning, float], None], scenario: Scenario, index: int, water_mps: float, where: str
) -> None:
    """Check a course or a task against a vehicle; put the key of its section before the message."""
    try:
        check(make_model(scenario.vehicles[index].model), water_mps)
    except ValueError as error:
        raise ValueError(f"{where}.{error}, for vehicles[{index}]") from None
