"""Checks across several values of a scenario: its parts must fit together."""

from __future__ import annotations

from typing import TYPE_CHECKING

import auv_control.controllers
import auv_core.models
from auv_control.controllers import ContinuousVelocityController, MotionLaw, controller_class, make_controller
from auv_control.courses import make_course
from auv_core.geometry import distance
from auv_core.models import make_model, thrusters_of
from auv_core.params import Section, shown
from auv_experiment.scenario.file import ID, ID_WORDS, MOST_VEHICLES
from auv_experiment.scenario.reach import check_reach
from auv_experiment.scenario.teams import agent_key, distinct_agents, team_of, teams
from auv_flocking.agent_config import SpokenReport, check_parts, report_format
from auv_flocking.consensus import ContinuousFilter, consensus_params, make_consensus
from auv_flocking.fleets import has_layers
from auv_flocking.flocking import LayeredParams, Member, flocking_params, make_flocking
from auv_flocking.separation import LearningLaw, make_separation
from auv_sim.acoustics.medium import AcousticMedium
from auv_sim.navigation import make_navigation
from auv_sim.vehicle import STEADY

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


def check_scenario(scenario: Scenario) -> None:
    """
    Check a scenario whose single values are allowed.

    Raises
    ------
    ValueError
        At the first mismatch; the message begins with the field.

    """
    for check in (
        _check_vehicles,
        _check_leaders,
        _check_agents,
        _check_contracts,
        _check_commands,
        _check_steps,
        _check_faults,
        _check_frames,
        _check_starts,
        _check_continuous,
        _check_reports,
        _check_layers,
    ):
        check(scenario)
    check_reach(scenario)


def _check_vehicles(scenario: Scenario) -> None:
    if not 1 <= len(scenario.vehicles) <= MOST_VEHICLES:
        raise ValueError(
            f"vehicles: {len(scenario.vehicles)} vehicles are not allowed; allowed: 1 to {MOST_VEHICLES}"
        )
    seen: set[str] = set()
    for index, vehicle in enumerate(scenario.vehicles):
        if not ID.match(vehicle.id):
            raise ValueError(f"vehicles[{index}].id: {shown(vehicle.id)} is not allowed; allowed: {ID_WORDS}")
        if vehicle.id in seen:
            raise ValueError(
                f"vehicles[{index}].id: {shown(vehicle.id)} is not allowed; "
                "allowed: an id that no other vehicle has"
            )
        seen.add(vehicle.id)


def _check_leaders(scenario: Scenario) -> None:
    ids = [vehicle.id for vehicle in scenario.vehicles]
    for index, leader in enumerate(scenario.leaders):
        if leader in scenario.leaders[:index]:
            raise ValueError(
                f"leaders[{index}]: {shown(leader)} is not allowed; allowed: an id that is no leader yet"
            )
        if leader not in ids:
            raise ValueError(f"leaders[{index}]: {shown(leader)} is not allowed; allowed: {', '.join(ids)}")


def _check_agents(scenario: Scenario) -> None:
    for index, agent in enumerate(scenario.agents):
        where = agent_key(scenario, index)
        owner = "" if scenario.vehicles[index].reference is None else f"vehicles[{index}]."
        check_parts(agent, scenario.reference_section(index), where=f"{where}.", owner=owner)
    if scenario.leaders and not any(agent.flocking for agent in scenario.agents):
        raise ValueError(
            f"leaders: {shown(list(scenario.leaders))} is not allowed; "
            "allowed: nothing, since there is no flock"
        )
    for index, vehicle in enumerate(scenario.vehicles):
        if vehicle.id in scenario.leaders and scenario.agents[index].flocking is None:
            at = scenario.leaders.index(vehicle.id)
            raise ValueError(
                f"leaders[{at}]: {shown(vehicle.id)} is not allowed; allowed: a vehicle that flocks"
            )
    if scenario.readings and scenario.follows_of(0) != "path":
        raise ValueError(
            "readings: not allowed; allowed: nothing, unless the controller follows a path by itself"
        )


def _check_contracts(scenario: Scenario) -> None:
    """The plugins of a vehicle have what their protocols ask for; those of the water are made below."""
    make_navigation(scenario.environment.navigation, scenario.seed, 1, scenario.period_s)
    for key, agent, indices in distinct_agents(scenario):
        make_controller(agent.controller, scenario.period_s)
        if agent.flocking is not None and agent.separation is not None:
            separation = make_separation(agent.separation)
            first = Member(True, 1, len(team_of(scenario, indices[0])))
            try:
                make_flocking(agent.flocking, separation, first)
            except ValueError as error:
                raise ValueError(f"{key}.flocking.params.{error}") from None
            flocking_params(agent.flocking)
        if agent.consensus is not None:
            consensus_params(agent.consensus)
        if agent.course is not None:
            make_course(agent.course, scenario.period_s)


def _check_reports(scenario: Scenario) -> None:
    """A version tells the kind of a report, so vehicles use a kind alike; and modems carry all of them."""
    kinds: dict[str, SpokenReport] = {}
    for key, agent, _ in distinct_agents(scenario):
        spoken, count = SpokenReport.of(agent), len(scenario.vehicles)
        known = kinds.setdefault(agent.report.kind, spoken)
        if known.bytes_of(count) != spoken.bytes_of(count):
            raise ValueError(
                f"{key}.report.kind: {agent.report.kind!r} is not allowed; allowed: another kind, since "
                "other vehicles use this one with other parameters or for another task"
            )
        try:
            AcousticMedium(scenario.medium_config).check_payload(report_format(agent, count).payload_bytes)
        except ValueError as error:
            raise ValueError(f"acoustics.{error}") from None


def _check_frames(scenario: Scenario) -> None:
    """Check that a law written for one frame steers a plant of that frame."""
    for index, vehicle in enumerate(scenario.vehicles):
        frame = auv_control.controllers.frame_of(scenario.agents[index].controller.params)
        plant = auv_core.models.frame_of(vehicle.model.params)
        if frame is not None and (frame == "flat") != (plant == "flat"):
            allowed = "flat" if plant == "flat" else "body, mixed"
            raise ValueError(
                f"{agent_key(scenario, index)}.controller.params.frame: {frame!r} is not allowed; "
                f"allowed: {allowed}, since the model of vehicles[{index}] has the frame {plant}"
            )


def _check_commands(scenario: Scenario) -> None:
    for index, vehicle in enumerate(scenario.vehicles):
        agent, key = scenario.agents[index], agent_key(scenario, index)
        given = controller_class(agent.controller.kind).command
        taken = make_model(vehicle.model).command
        if taken != given and (taken, given) != ("thrusters", "wrench"):
            raise ValueError(
                f"{key}.controller.kind: {agent.controller.kind!r} is not allowed; "
                "allowed: a controller that gives "
                f"the {taken} command that the model of vehicles[{index}] takes"
            )
        if agent.hold_s > 0.0 and not make_model(vehicle.model).handling.can_stop:
            raise ValueError(
                f"{key}.hold_s: {agent.hold_s!r} is not allowed; allowed: 0, "
                f"since vehicles[{index}] cannot stop"
            )
    environment, is_kinematic = scenario.environment, "velocity" in scenario.commands
    if is_kinematic and environment.current.kind != STEADY.kind:
        raise ValueError(
            f"environment.current.kind: {environment.current.kind!r} is not allowed; allowed: "
            f"{STEADY.kind} with kinematic vehicles, whose velocity command is over ground"
        )
    if is_kinematic and any(environment.current_ned_mps):
        raise ValueError(
            "environment.current_ned_mps: a current is not allowed; allowed: [0, 0, 0] with "
            "kinematic vehicles, "
            "whose velocity command is over ground"
        )


def _check_steps(scenario: Scenario) -> None:
    """Check that the step of integration is short enough for every vehicle."""
    for index, vehicle in enumerate(scenario.vehicles):
        longest_s = make_model(vehicle.model).longest_step_s
        if scenario.dt_s > longest_s:
            raise ValueError(
                f"dt_s: {scenario.dt_s!r} is not allowed; allowed: at most {longest_s:g} s "
                f"for the actuators of vehicles[{index}]"
            )


def _check_faults(scenario: Scenario) -> None:
    for index, vehicle in enumerate(scenario.vehicles):
        count = thrusters_of(vehicle.model).count
        if vehicle.fault.thruster > count:
            allowed = f"at most {count}" if count else "0, since the vehicle has no thrusters"
            raise ValueError(
                f"vehicles[{index}].fault.thruster: {vehicle.fault.thruster} is not allowed; "
                f"allowed: {allowed}"
            )
        if vehicle.propeller_limit_rpm is not None and make_model(vehicle.model).command != "fins":
            raise ValueError(
                f"vehicles[{index}].propeller_limit_rpm: {vehicle.propeller_limit_rpm!r} is not allowed; "
                "allowed: null, since the vehicle takes no speed of a propeller"
            )


def _check_starts(scenario: Scenario) -> None:
    starts = scenario.random_starts
    has_any_layers = any(has_layers(agent.fleet) for agent in scenario.agents)
    if starts is not None and starts.depths == "layers" and not has_any_layers:
        raise ValueError(
            "random_starts.depths: 'layers' is not allowed; allowed: ball, centre, since agent.fleet has no "
            "layers of depth"
        )
    placed = [(i, v.position_ned_m) for i, v in enumerate(scenario.vehicles) if v.position_ned_m is not None]
    if len(placed) < len(scenario.vehicles) and scenario.random_starts is None:
        index = next(i for i, v in enumerate(scenario.vehicles) if v.position_ned_m is None)
        raise ValueError(
            f"vehicles[{index}].position_ned_m: missing; allowed: a position here, or random_starts"
        )
    radii_m = scenario.hull_radii_m
    for index, start in placed:
        if start[2] < 0.0:
            raise ValueError(
                f"vehicles[{index}].position_ned_m: depth {start[2]!r} m is not allowed; allowed: at least 0"
            )
        for other, place in placed:
            touch_m = radii_m[index] + radii_m[other]
            if other < index and distance(start, place) <= touch_m:
                raise ValueError(
                    f"vehicles[{index}].position_ned_m: touches vehicles[{other}]; allowed: more than "
                    f"{touch_m:g} m between hull centres"
                )
        for number, obstacle in enumerate(scenario.environment.obstacles):
            if distance(start, obstacle.position_ned_m) <= radii_m[index]:
                raise ValueError(
                    f"environment.obstacles[{number}].position_ned_m: lies in the hull "
                    f"of vehicles[{index}]; "
                    "allowed: a place outside every hull"
                )


def _check_continuous(scenario: Scenario) -> None:
    if scenario.sampling != "continuous":
        return
    if "thrusters" in scenario.commands:
        raise _not_continuous(
            ", for vehicles with thrusters, whose forces are chosen once per control period"
        )
    if len(distinct_agents(scenario)) > 1:
        raise _not_continuous(", unless all vehicles have the same agent")
    agent, acoustics = scenario.agents[0], scenario.acoustics
    controller = make_controller(agent.controller, scenario.period_s)
    if not scenario.kinematic and not isinstance(controller, ContinuousVelocityController | MotionLaw):
        raise _not_continuous(
            f", for the controller {agent.controller.kind}, which works once per control period"
        )
    if scenario.environment.navigation.kind != "exact":
        raise _not_continuous(", unless environment.navigation is exact")
    if scenario.environment.current.kind != STEADY.kind:
        raise _not_continuous(f", unless environment.current is {STEADY.kind}")
    ideal = acoustics.propagation.kind == "instant" and acoustics.outage.kind == "none"
    ideal = ideal and acoustics.mac.kind == "unlimited" and acoustics.modem.kind == "ideal"
    if not ideal and scenario.follows_of(0) != "path":
        raise _not_continuous(
            ", unless acoustics.preset is ideal or the controller follows a path and uses no reports"
        )
    if not all(obstacle.known for obstacle in scenario.environment.obstacles):
        raise _not_continuous(", unless every environment.obstacles is known")
    if agent.flocking is not None and flocking_params(agent.flocking).uses_flock_velocity:
        raise _not_continuous(", since agent.flocking.params send the flock's velocity in packets")
    if agent.separation is not None and isinstance(make_separation(agent.separation), LearningLaw):
        raise _not_continuous(", since agent.separation has a memory that is updated once per control period")
    if agent.consensus is not None:
        _check_continuous_filter(agent.consensus, len(scenario.vehicles))


def _check_continuous_filter(consensus: Section, fleet_size: int) -> None:
    if consensus_params(consensus).uses_flock_velocity:
        raise _not_continuous(", since agent.consensus.params send the flock's velocity in packets")
    if not isinstance(make_consensus(consensus, fleet_size), ContinuousFilter):
        raise _not_continuous(", since agent.consensus works once per control period")


def _not_continuous(why: str) -> ValueError:
    return ValueError(f"sampling: 'continuous' is not allowed; allowed: sampled{why}")


def _check_layers(scenario: Scenario) -> None:
    """Check that hulls in neighbouring layers of depth cannot touch."""
    radii_m = scenario.hull_radii_m
    for indices in teams(scenario):
        flocking, others = scenario.agents[indices[0]].flocking, len(indices) - 1
        if flocking is None or others == 0:
            continue
        params = flocking.params
        height_m = params.height_m(others + 1) if isinstance(params, LayeredParams) else 0.0
        radius_m = max(radii_m[index] for index in indices)
        least_m = 2.0 * radius_m * others
        if 0.0 < height_m <= least_m:
            raise ValueError(
                f"{agent_key(scenario, indices[0])}.flocking.params: {others + 1} layers within "
                f"{height_m:.6g} m are not allowed; allowed: a layer_m and a layer_span_m that give more "
                f"than {least_m:.6g} m, since the hulls have a radius of {radius_m:g} m"
            )
