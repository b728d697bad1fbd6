"""
Checks that a scenario stays within the limits of its actuators, the water, its modems and its reports.

Paths, regions, starts, speeds and the current determine where vehicles can be and how fast they must move.
The plugins state what they can hold, hear or carry. A scenario that exceeds a limit is refused before
anything starts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from auv_control.controllers import max_force_of, region_of
from auv_control.courses import make_course
from auv_control.references import ReferencePath
from auv_core.geometry import Box, Vec3
from auv_core.models import make_model
from auv_core.params import Section
from auv_experiment.scenario.hearing import check_hearing
from auv_experiment.scenario.task_checks import check_tasks, fleet_task
from auv_experiment.scenario.teams import agent_key, distinct_agents, flocks, starts_of, teams
from auv_flocking.agent_config import report_format
from auv_flocking.flocking import flocking_params
from auv_flocking.reports import Bounds, ReportFormat
from auv_sim.acoustics.propagation import bottom_m
from auv_sim.currents import make_current

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

_PATH_SAMPLES = 64
_AXES = ("north", "east", "down")


def check_reach(scenario: Scenario) -> None:
    """
    Check a scenario whose parts fit together.

    Raises
    ------
    ValueError
        At the first value that exceeds a limit; the message begins with the field.

    """
    for check in (
        _check_speeds,
        _check_start_speeds,
        _check_tasks,
        _check_surface,
        _check_bottom,
        _check_report_positions,
        _check_report_velocities,
        _check_report_centres,
        check_hearing,
    ):
        check(scenario)


def water_speed_mps(scenario: Scenario) -> float:
    """Return a speed that the current seldom exceeds (m/s)."""
    return math.hypot(*scenario.environment.current_ned_mps) + _current_varies_by_mps(scenario)


def _current_varies_by_mps(scenario: Scenario) -> float:
    environment = scenario.environment
    mean_ned_mps = environment.current_ned_mps
    return make_current(environment.current, mean_ned_mps, scenario.seed, 1, scenario.period_s).varies_by_mps


def _check_speeds(scenario: Scenario) -> None:
    """Check that the actuators hold a vehicle in the current and move it along its path through the water."""
    current = scenario.environment.current_ned_mps
    water_mps, varies_by_mps = water_speed_mps(scenario), _current_varies_by_mps(scenario)
    water_key = "environment.current_ned_mps" if varies_by_mps == 0.0 else "environment.current"
    for index, vehicle in enumerate(scenario.vehicles):
        model = make_model(vehicle.model)
        held_mps = model.speed_held_mps(max_force_of(scenario.agents[index].controller.params))
        holder = "actuators" if held_mps == model.top_speed_mps else "controller and actuators"
        held = f"at most {held_mps:.3g} m/s, which the {holder} of vehicles[{index}] hold against the drag"
        if water_mps > held_mps:
            raise ValueError(
                f"{water_key}: runs at {water_mps:.3g} m/s, which is not allowed; allowed: {held}"
            )
        path = scenario.reference_of(index)
        speed_mps = 0.0 if path is None else _fastest_mps(path, scenario.duration_s, current) + varies_by_mps
        if speed_mps > held_mps:
            raise ValueError(
                f"{_path_key(scenario, index)}: runs at {speed_mps:.3g} m/s through the water, "
                f"which is not allowed; allowed: {held}"
            )
        handling = model.handling
        slowest_mps = math.inf if path is None else _slowest_mps(path, scenario.duration_s, current)
        if not handling.can_stop and slowest_mps - varies_by_mps < handling.least_speed_mps:
            raise ValueError(
                f"{_path_key(scenario, index)}: runs at {max(0.0, slowest_mps - varies_by_mps):.3g} m/s "
                f"through the water, which is not allowed; allowed: at least {handling.least_speed_mps:.3g} "
                f"m/s, at which vehicles[{index}] obeys its command"
            )


def _check_start_speeds(scenario: Scenario) -> None:
    """Check that the actuators hold the speed through the water at which a vehicle starts."""
    north_mps, east_mps, down_mps = scenario.environment.current_ned_mps
    for index, vehicle in enumerate(scenario.vehicles):
        top_mps, speed_mps = make_model(vehicle.model).top_speed_mps, vehicle.speed_mps
        through_mps = math.hypot(
            speed_mps * math.cos(vehicle.heading_rad) - north_mps,
            speed_mps * math.sin(vehicle.heading_rad) - east_mps,
            down_mps,
        )
        if speed_mps > 0.0 and through_mps > top_mps:
            raise ValueError(
                f"vehicles[{index}].speed_mps: {speed_mps!r} m/s over ground is {through_mps:.3g} m/s "
                f"through the water, which is not allowed; allowed: at most {top_mps:.3g} m/s there"
            )


def _check_tasks(scenario: Scenario) -> None:
    check_tasks(scenario, water_speed_mps(scenario))


def _check_surface(scenario: Scenario) -> None:
    for index in range(len(scenario.vehicles)):
        reach = _reach(scenario, index)
        if reach is not None and reach.lowest[2] < 0.0:
            raise ValueError(
                f"{_path_key(scenario, index)}: rises {-reach.lowest[2]:.3g} m above the surface within "
                f"{scenario.duration_s:g} s, which is not allowed; allowed: depths of at least 0 m"
            )


def _check_bottom(scenario: Scenario) -> None:
    """Check that vehicles stay above the sea floor, if the propagation has one."""
    deepest_m = bottom_m(scenario.acoustics.propagation)
    for _, key, reach in _places(scenario):
        if reach.highest[2] > deepest_m:
            raise ValueError(
                f"{key}: reaches a depth of {reach.highest[2]:.6g} m, which is not allowed; allowed: at most "
                f"{deepest_m:g} m, acoustics.propagation.params.water_depth_m"
            )


def _check_report_positions(scenario: Scenario) -> None:
    """Check that reports can carry every position that starts, path and formation can reach."""
    bounds = _bounds(scenario)
    for index, key, reach in _places(scenario):
        carried = bounds[index].position
        for axis in range(3):
            for value, is_inside in (
                (reach.lowest[axis], reach.lowest[axis] >= carried.lowest[axis]),
                (reach.highest[axis], reach.highest[axis] <= carried.highest[axis]),
            ):
                if not is_inside:
                    raise ValueError(
                        f"{key}: reaches {_AXES[axis]} {value:.6g} m, which is not allowed; allowed: "
                        f"{carried.lowest[axis]:.6g} to {carried.highest[axis]:.6g} m, "
                        f"which a report of the kind {_report_kind(scenario, index)} carries"
                    )


def _check_report_velocities(scenario: Scenario) -> None:
    """Check that reports can carry the largest speed over ground, and the steepest part of a path."""
    bounds = _bounds(scenario)
    for index, vehicle in enumerate(scenario.vehicles):
        path, flocking = scenario.reference_of(index), scenario.agents[index].flocking
        most_mps = bounds[index].velocity_mps
        if path is None:
            continue
        fastest_mps = _fastest_mps(path, scenario.duration_s, (0.0, 0.0, 0.0))
        if flocking is not None:
            model = make_model(vehicle.model)
            asked_mps = fastest_mps + flocking_params(flocking).largest_correction_mps
            driven_mps = model.top_speed_mps + water_speed_mps(scenario)
            bounded_mps = min(asked_mps, driven_mps)
            if math.isfinite(bounded_mps):  # else the law's error sets the speed, and only the path is known
                fastest_mps = bounded_mps
        if fastest_mps > most_mps:
            raise ValueError(
                f"{_path_key(scenario, index)}: lets vehicles[{index}] move at {fastest_mps:.3g} m/s, "
                f"which is not allowed; allowed: at most {most_mps:.3g} m/s, "
                f"which a report of the kind {_report_kind(scenario, index)} carries"
            )
        steepest_mps = _steepest_mps(path, scenario.duration_s)
        if steepest_mps > bounds[index].descent_mps:
            raise ValueError(
                f"{_path_key(scenario, index)}: dives or climbs at {steepest_mps:.3g} m/s, which is not "
                f"allowed; allowed: at most {bounds[index].descent_mps:.3g} m/s, "
                f"which a report of the kind {_report_kind(scenario, index)} carries"
            )


def _check_report_centres(scenario: Scenario) -> None:
    """
    Check that reports can carry the vector from each vehicle of a flock to its centre, which is among its
    vehicles.
    """
    for indices in flocks(scenario):
        most_m = _report_format(scenario, indices[0]).carries.centre_distance_m
        starts = [start for _, start in starts_of(scenario, indices)]
        for axis in range(3):
            along_m = [start[axis] for start in starts]
            spread_m = max(along_m, default=0.0) - min(along_m, default=0.0)
            if spread_m > most_m:
                raise ValueError(
                    f"vehicles: start {spread_m:.6g} m apart ({_AXES[axis]}), which is not allowed; allowed: "
                    f"at most {most_m:.6g} m, since a report of the kind "
                    f"{_report_kind(scenario, indices[0])} carries "
                    "the flocking centre at most this far from its vehicle"
                )


def _places(scenario: Scenario) -> list[tuple[int, str, Box]]:
    """
    Return where vehicles start and where their paths or regions lead, each with the vehicle's index and its
    key in the scenario.
    """
    places = [
        (index, f"vehicles[{index}].position_ned_m", Box(start, start))
        for index, start in starts_of(scenario, range(len(scenario.vehicles)))
    ]
    for indices in teams(scenario):
        for index in indices:
            reach = _reach(scenario, index)
            if reach is not None:
                size_m = _formation_size_m(scenario.agents[index].flocking, len(indices))
                places.append((index, _path_key(scenario, index), reach.grown(*size_m)))
    return places


def _reach(scenario: Scenario, index: int) -> Box | None:
    """Return a box around the path of a vehicle, its lane or its region (m; NED)."""
    agent = scenario.agents[index]
    if scenario.follows_of(index) == "region":
        return region_of(agent.controller, scenario.period_s)
    if agent.course is not None:
        return make_course(agent.course, scenario.period_s).reach(scenario.duration_s)
    if agent.fleet is not None:
        return fleet_task(scenario, index).reach()
    path = scenario.reference_of(index)
    return None if path is None else path.reach(scenario.duration_s)


def _path_key(scenario: Scenario, index: int) -> str:
    agent, follows = scenario.agents[index], scenario.follows_of(index)
    if follows in ("region", "course"):
        task = "course" if agent.fleet is None else "fleet"
        section = "controller" if follows == "region" else task
        return f"{agent_key(scenario, index)}.{section}.params"
    return "reference" if scenario.vehicles[index].reference is None else f"vehicles[{index}].reference"


def _formation_size_m(flocking: Section | None, count: int) -> tuple[float, float]:
    """
    Return how far a formed flock reaches from its path, horizontally and vertically (m): a ball with room for
    each vehicle, or the extent of a formation with slots.
    """
    if flocking is None:
        return 0.0, 0.0
    params: Any = flocking.params
    if hasattr(params, "extent_m"):
        return params.extent_m(count), params.height_m(count)
    radius_m = flocking_params(flocking).formation_spacing_m * math.cbrt(count)
    return radius_m, radius_m


def _fastest_mps(path: ReferencePath, duration_s: float, current: Sequence[float]) -> float:
    """Return the largest speed along a path, relative to the moving water (m/s; NED)."""
    return max(math.dist(velocity, current) for velocity in _velocities(path, duration_s))


def _slowest_mps(path: ReferencePath, duration_s: float, current: Sequence[float]) -> float:
    """Return the smallest speed along a path, relative to the moving water (m/s; NED)."""
    return min(math.dist(velocity, current) for velocity in _velocities(path, duration_s))


def _steepest_mps(path: ReferencePath, duration_s: float) -> float:
    """Return the largest vertical speed along a path (m/s)."""
    return max(abs(velocity[2]) for velocity in _velocities(path, duration_s))


def _velocities(path: ReferencePath, duration_s: float) -> list[Vec3]:
    """Return samples of the velocity along a path, over one round if it has one (m/s; NED)."""
    span_s = duration_s if path.period_s is None else min(path.period_s, duration_s)
    return [path.at(span_s * k / _PATH_SAMPLES).velocity for k in range(_PATH_SAMPLES + 1)]


def _bounds(scenario: Scenario) -> dict[int, Bounds]:
    """Return what the reports of each vehicle carry."""
    bounds: dict[int, Bounds] = {}
    for software in distinct_agents(scenario):
        bounds |= dict.fromkeys(software.vehicles, _report_format(scenario, software.vehicles[0]).carries)
    return bounds


def _report_kind(scenario: Scenario, index: int) -> str:
    return scenario.agents[index].report.kind


def _report_format(scenario: Scenario, index: int) -> ReportFormat:
    return report_format(scenario.agents[index], len(scenario.vehicles))
