"""
Checks that a scenario stays within the limits of its actuators, the water, its modems and its reports.

Paths, regions, starts, speeds and the current determine where vehicles can be and how fast they must move.
The plugins state what they can hold, hear or carry. A scenario that exceeds a limit is refused before
anything starts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from auv_control.controllers import max_force_of, region_of
from auv_control.courses import make_course
from auv_control.references import ReferencePath
from auv_core.geometry import Box, Vec3, distance
from auv_core.models import make_model
from auv_experiment.scenario.task_checks import check_tasks, fleet_task
from auv_flocking.agent_config import report_format
from auv_flocking.flocking import flocking_params
from auv_flocking.reports import Bounds, ReportFormat
from auv_sim.acoustics.modem import AcousticModem, LevelModem, make_modem
from auv_sim.acoustics.propagation import SoundPropagation, bottom_m, make_propagation
from auv_sim.currents import make_current

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

_PATH_SAMPLES = 64
# A link that carries fewer reports than one in a hundred, with ambient noise alone, is none.
_LEAST_LOG_SUCCESS = math.log(0.01)
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
        _check_hearing,
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
        held_mps = model.speed_held_mps(max_force_of(scenario.agent.controller.params))
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
    for key, reach in _places(scenario):
        if reach.highest[2] > deepest_m:
            raise ValueError(
                f"{key}: reaches a depth of {reach.highest[2]:.6g} m, which is not allowed; allowed: at most "
                f"{deepest_m:g} m, acoustics.propagation.params.water_depth_m"
            )


def _check_report_positions(scenario: Scenario) -> None:
    """Check that reports can carry every position that starts, path and formation can reach."""
    carried = _bounds(scenario).position
    for key, reach in _places(scenario):
        for axis in range(3):
            for value, is_inside in (
                (reach.lowest[axis], reach.lowest[axis] >= carried.lowest[axis]),
                (reach.highest[axis], reach.highest[axis] <= carried.highest[axis]),
            ):
                if not is_inside:
                    raise ValueError(
                        f"{key}: reaches {_AXES[axis]} {value:.6g} m, which is not allowed; allowed: "
                        f"{carried.lowest[axis]:.6g} to {carried.highest[axis]:.6g} m, "
                        f"which a report of the kind {scenario.agent.report.kind} carries"
                    )


def _check_report_velocities(scenario: Scenario) -> None:
    """Check that reports can carry the largest speed over ground, and the steepest part of a path."""
    bounds = _bounds(scenario)
    most_mps = bounds.velocity_mps
    for index, vehicle in enumerate(scenario.vehicles):
        path = scenario.reference_of(index)
        if path is None:
            continue
        fastest_mps = _fastest_mps(path, scenario.duration_s, (0.0, 0.0, 0.0))
        if scenario.agent.flocking is not None:
            model = make_model(vehicle.model)
            asked_mps = fastest_mps + flocking_params(scenario.agent.flocking).largest_correction_mps
            driven_mps = model.top_speed_mps + water_speed_mps(scenario)
            bounded_mps = min(asked_mps, driven_mps)
            if math.isfinite(bounded_mps):  # else the law's error sets the speed, and only the path is known
                fastest_mps = bounded_mps
        if fastest_mps > most_mps:
            raise ValueError(
                f"{_path_key(scenario, index)}: lets vehicles[{index}] move at {fastest_mps:.3g} m/s, "
                f"which is not allowed; allowed: at most {most_mps:.3g} m/s, "
                f"which a report of the kind {scenario.agent.report.kind} carries"
            )
        steepest_mps = _steepest_mps(path, scenario.duration_s)
        if steepest_mps > bounds.descent_mps:
            raise ValueError(
                f"{_path_key(scenario, index)}: dives or climbs at {steepest_mps:.3g} m/s, which is not "
                f"allowed; allowed: at most {bounds.descent_mps:.3g} m/s, "
                f"which a report of the kind {scenario.agent.report.kind} carries"
            )


def _check_report_centres(scenario: Scenario) -> None:
    """
    Check that reports can carry the vector from each vehicle to the flocking centre, which is among the
    vehicles.
    """
    if scenario.agent.flocking is None:
        return
    most_m = _bounds(scenario).centre_distance_m
    starts = _starts(scenario)
    for axis in range(3):
        along_m = [start[axis] for start in starts]
        spread_m = max(along_m, default=0.0) - min(along_m, default=0.0)
        if spread_m > most_m:
            raise ValueError(
                f"vehicles: start {spread_m:.6g} m apart ({_AXES[axis]}), which is not allowed; allowed: "
                f"at most {most_m:.6g} m, since a report of the kind {scenario.agent.report.kind} carries "
                "the flocking centre at most this far from its vehicle"
            )


def _check_hearing(scenario: Scenario) -> None:
    """Check that the modems of a flock form one connected network at the starts."""
    starts = _starts(scenario)
    if scenario.agent.flocking is None or len(starts) < len(scenario.vehicles):
        return
    modem, propagation = (
        make_modem(scenario.acoustics.modem),
        make_propagation(scenario.acoustics.propagation),
    )
    hears = partial(_hears, modem, propagation, _report_format(scenario).payload_bytes)
    deaf = set(range(1, len(starts)))
    heard = [0]
    while heard and deaf:
        speaker = starts[heard.pop()]
        reached = {index for index in deaf if hears(speaker, starts[index])}
        deaf -= reached
        heard += sorted(reached)
    if deaf:
        raise ValueError(
            f"vehicles[{min(deaf)}].position_ned_m: out of range of vehicles[0] and of every vehicle "
            "connected to it, which is not allowed; allowed: a start within range of acoustics.modem "
            f"({scenario.acoustics.modem.kind})"
        )


def _hears(
    modem: AcousticModem, propagation: SoundPropagation, payload_bytes: int, source: Vec3, receiver: Vec3
) -> bool:
    """Return whether a modem recognises packets and gets some of them right, in ambient noise alone."""
    if distance(source, receiver) > modem.max_range_m:
        return False
    if not isinstance(modem, LevelModem):
        return True
    loss_db = propagation.loss_db(source, receiver, modem.frequency_khz)
    snr_ratio = modem.snr_ratio(loss_db)
    return modem.acquires(snr_ratio) and modem.log_success(snr_ratio, payload_bytes) > _LEAST_LOG_SUCCESS


def _places(scenario: Scenario) -> list[tuple[str, Box]]:
    """
    Return where vehicles start and where their paths or regions lead, each with its key in the scenario.
    """
    places = [
        (f"vehicles[{index}].position_ned_m", Box(vehicle.position_ned_m, vehicle.position_ned_m))
        for index, vehicle in enumerate(scenario.vehicles)
        if vehicle.position_ned_m is not None
    ]
    for index in range(len(scenario.vehicles)):
        reach = _reach(scenario, index)
        if reach is not None:
            places.append((_path_key(scenario, index), reach.grown(*_formation_size_m(scenario))))
    return places


def _reach(scenario: Scenario, index: int) -> Box | None:
    """Return a box around the path of a vehicle, its lane or its region (m; NED)."""
    if scenario.follows == "region":
        return region_of(scenario.agent.controller, scenario.period_s)
    if scenario.agent.course is not None:
        return make_course(scenario.agent.course, scenario.period_s).reach(scenario.duration_s)
    if scenario.agent.fleet is not None:
        return fleet_task(scenario, index).reach()
    path = scenario.reference_of(index)
    return None if path is None else path.reach(scenario.duration_s)


def _path_key(scenario: Scenario, index: int) -> str:
    if scenario.follows == "region":
        return "agent.controller.params"
    if scenario.follows == "course":
        return "agent.course.params" if scenario.agent.fleet is None else "agent.fleet.params"
    return "reference" if scenario.vehicles[index].reference is None else f"vehicles[{index}].reference"


def _formation_size_m(scenario: Scenario) -> tuple[float, float]:
    """
    Return how far a formed flock reaches from its path, horizontally and vertically (m): a ball with room for
    each vehicle, or the extent of a formation with slots.
    """
    if scenario.agent.flocking is None:
        return 0.0, 0.0
    params: Any = scenario.agent.flocking.params
    if hasattr(params, "extent_m"):
        count = len(scenario.vehicles)
        return params.extent_m(count), params.height_m(count)
    spacing_m = flocking_params(scenario.agent.flocking).formation_spacing_m
    radius_m = spacing_m * math.cbrt(len(scenario.vehicles))
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


def _starts(scenario: Scenario) -> list[Vec3]:
    """Return the starts that are given or already drawn (m; NED)."""
    return [v.position_ned_m for v in scenario.vehicles if v.position_ned_m is not None]


def _bounds(scenario: Scenario) -> Bounds:
    return _report_format(scenario).carries


def _report_format(scenario: Scenario) -> ReportFormat:
    agent = scenario.agent
    return report_format(agent, len(scenario.vehicles))
