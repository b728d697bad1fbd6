"""
The vehicles of a scenario by what they do: which have the same software, and which do one task together.

A *team* is a flock (vehicles with the same sections `flocking`, `separation` and `consensus`), a fleet (the
same section `fleet`), or vehicles that act by themselves with the same software. What looks at one task, such
as a law's metrics, looks at one team, as a scenario of its own.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from auv_core.geometry import Vec3
from auv_flocking.agent_config import AgentSettings

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

COMMON = "agent"


class Software(NamedTuple):
    """The software of some vehicles: its key in the scenario, the section, and the vehicles' indices."""

    key: str
    agent: AgentSettings
    vehicles: tuple[int, ...]


def distinct_agents(scenario: Scenario) -> list[Software]:
    """Return every software that a vehicle of the scenario has, once, in the order of vehicles."""
    found: list[Software] = []
    for index, agent in enumerate(scenario.agents):
        at = next((i for i, known in enumerate(found) if known.agent == agent), None)
        if at is None:
            found.append(Software(agent_key(scenario, index), agent, (index,)))
        else:
            found[at] = found[at]._replace(vehicles=(*found[at].vehicles, index))
    return found


def agent_key(scenario: Scenario, index: int) -> str:
    """Return the key of a vehicle's software."""
    return COMMON if scenario.vehicles[index].agent is None else f"vehicles[{index}].agent"


def teams(scenario: Scenario) -> list[tuple[int, ...]]:
    """Return the indices of the vehicles of each team, in the order of their first vehicles."""
    found: list[tuple[Any, list[int]]] = []
    for software in distinct_agents(scenario):
        task = _task(software.agent)
        mates = next((indices for known, indices in found if known == task), None)
        if mates is None:
            found.append((task, list(software.vehicles)))
        else:
            mates += software.vehicles
    return [tuple(sorted(indices)) for _, indices in found]


def team_of(scenario: Scenario, index: int) -> tuple[int, ...]:
    """Return the indices of the vehicles of a vehicle's team."""
    return next(indices for indices in teams(scenario) if index in indices)


def flocks(scenario: Scenario) -> list[tuple[int, ...]]:
    """Return the indices of the vehicles of each team that is a flock."""
    return [indices for indices in teams(scenario) if scenario.agents[indices[0]].flocking is not None]


def starts_of(scenario: Scenario, indices: Iterable[int]) -> list[tuple[int, Vec3]]:
    """Return the starts of vehicles that are given or already drawn (m; NED), with the vehicles' indices."""
    return [
        (index, start) for index in indices if (start := scenario.vehicles[index].position_ned_m) is not None
    ]


def is_group(agent: AgentSettings) -> bool:
    """Return whether vehicles with this software do their task together."""
    return agent.fleet is not None or agent.flocking is not None


def has_one_agent(scenario: Scenario) -> bool:
    """Return whether no vehicle has an agent of its own."""
    return all(vehicle.agent is None for vehicle in scenario.vehicles)


def team_scenarios(scenario: Scenario) -> list[Scenario]:
    """Return the scenario of each team, in the order of their first vehicles."""
    if has_one_agent(scenario):
        return [scenario]
    return [of_team(scenario, indices) for indices in teams(scenario)]


def of_team(scenario: Scenario, indices: Iterable[int]) -> Scenario:
    """Return the scenario of one team; its section `agent` is the software of the first vehicle."""
    taken = tuple(indices)
    paths = [scenario.reference_section(index) for index in taken]
    vehicles = tuple(replace(scenario.vehicles[i], agent=scenario.agents[i]) for i in taken)
    names = {vehicle.id for vehicle in vehicles}
    return replace(
        scenario,
        vehicles=vehicles,
        agent=scenario.agents[taken[0]],
        leaders=tuple(leader for leader in scenario.leaders if leader in names),
        reference=paths[0] if all(path == paths[0] for path in paths) else scenario.reference,
        readings=scenario.readings if taken[0] == 0 else (),
    )


def _task(agent: AgentSettings) -> Any:
    if agent.fleet is not None:
        return agent.fleet
    if agent.flocking is not None:
        return agent.flocking, agent.separation, agent.consensus
    return agent
