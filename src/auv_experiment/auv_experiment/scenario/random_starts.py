"""Random starts drawn with the seed: in a ball or a disc, apart from each other and below the surface."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from auv_core.geometry import Vec3, distance
from auv_core.models import make_model
from auv_core.params import ConfigError
from auv_experiment.scenario.teams import teams
from auv_flocking.fleets import has_layers, layers_of

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import RandomStarts, Scenario, VehicleEntry

DEPTHS = ("ball", "centre", "layers")
"""Where starts are: in a ball, or in a disc at the depth of its centre or of each vehicle's layer."""

_STARTS_STREAM = 2
_START_TRIES = 20_000
_DISC_TRIES = 2_000
_DISC_ROUNDS = 10


def with_starts(scenario: Scenario) -> Scenario:
    """Return the scenario with every start position given."""
    starts = scenario.random_starts
    if starts is None or all(vehicle.position_ned_m is not None for vehicle in scenario.vehicles):
        return scenario
    rng = np.random.default_rng(np.random.SeedSequence((scenario.seed, _STARTS_STREAM)))
    if starts.depths == "ball":
        vehicles = _in_a_ball(rng, starts, scenario.vehicles)
    else:
        vehicles = _in_a_disc(rng, starts, scenario)
    vehicles = [
        vehicle if given.position_ned_m else _set_off(rng, starts, vehicle)
        for vehicle, given in zip(vehicles, scenario.vehicles, strict=True)
    ]
    try:
        return replace(scenario, vehicles=tuple(vehicles))
    except ValueError as error:
        raise ConfigError(f"scenario.{error}") from None


def _set_off(rng: np.random.Generator, starts: RandomStarts, vehicle: VehicleEntry) -> VehicleEntry:
    """Return a vehicle with a drawn heading, and one that cannot stop with a speed, if it has none."""
    lies_still = vehicle.speed_mps == 0.0 and not make_model(vehicle.model).handling.can_stop
    if lies_still:
        vehicle = replace(vehicle, speed_mps=starts.speed_mps)
    if starts.any_heading or lies_still:
        return replace(vehicle, heading_rad=float(rng.uniform(-math.pi, math.pi)))
    return vehicle


def _in_a_ball(
    rng: np.random.Generator, starts: RandomStarts, given: Sequence[VehicleEntry]
) -> list[VehicleEntry]:
    """Return the vehicles, those without a start in the ball and apart from all."""
    taken = [vehicle.position_ned_m for vehicle in given if vehicle.position_ned_m is not None]
    drawn: list[Vec3] = []
    for _ in range(len(given) - len(taken)):
        drawn.append(_draw_start(rng, starts, [*taken, *drawn]))
    if starts.in_depth_order:
        drawn.sort(key=lambda position: position[2])
    left = iter(drawn)
    return [v if v.position_ned_m is not None else replace(v, position_ned_m=next(left)) for v in given]


def _draw_start(rng: np.random.Generator, starts: RandomStarts, taken: Sequence[Vec3]) -> Vec3:
    for _ in range(_START_TRIES):
        offset = rng.uniform(-starts.radius_m, starts.radius_m, 3)
        x, y, z = (float(c + o) for c, o in zip(starts.centre_ned_m, offset, strict=True))
        inside = math.hypot(*offset) <= starts.radius_m and z >= starts.depth_min_m
        if inside and all(distance((x, y, z), other) >= starts.separation_m for other in taken):
            return (x, y, z)
    raise _no_room(starts, len(taken) + 1)


def _in_a_disc(rng: np.random.Generator, starts: RandomStarts, scenario: Scenario) -> list[VehicleEntry]:
    """Return the vehicles, those without a start in the disc and apart from all on the map."""
    given = scenario.vehicles
    depths_m = [starts.centre_ned_m[2]] * len(given)
    if starts.depths == "layers":
        for indices in teams(scenario):
            fleet = scenario.agents[indices[0]].fleet
            if has_layers(fleet):
                for index, layer_m in zip(indices, layers_of(fleet, len(indices)), strict=True):
                    depths_m[index] = layer_m
    held = [vehicle.position_ned_m[:2] for vehicle in given if vehicle.position_ned_m is not None]
    count = len(given) - len(held)
    for _ in range(_DISC_ROUNDS):  # a bad first place may leave no room for the last one
        drawn = _disc_places(rng, starts, held, count)
        if len(drawn) == count:
            places = iter(drawn)
            return [
                vehicle
                if vehicle.position_ned_m is not None
                else replace(vehicle, position_ned_m=(*next(places), depth_m))
                for vehicle, depth_m in zip(given, depths_m, strict=True)
            ]
    raise _no_room(starts, len(given))


def _disc_places(
    rng: np.random.Generator, starts: RandomStarts, held: Sequence[tuple[float, float]], count: int
) -> list[tuple[float, float]]:
    """Return places on the map (m; NED), fewer than `count` if there is no room in some tries."""
    north_m, east_m, _ = starts.centre_ned_m
    places: list[tuple[float, float]] = []
    for _ in range(_DISC_TRIES):
        if len(places) == count:
            break
        x, y = rng.uniform(-starts.radius_m, starts.radius_m, 2).tolist()
        place = (north_m + x, east_m + y)
        taken = (*held, *places)
        if math.hypot(x, y) <= starts.radius_m and all(
            math.dist(place, other) >= starts.separation_m for other in taken
        ):
            places.append(place)
    return places


def _no_room(starts: RandomStarts, count: int) -> ConfigError:
    depth = f" or a smaller depth_min_m ({starts.depth_min_m:g})" if starts.depths == "ball" else ""
    joint = "," if depth else " or"
    return ConfigError(
        f"scenario.random_starts: no room for {count} vehicles; "
        f"allowed: a larger radius_m ({starts.radius_m:g}){joint} "
        f"a smaller separation_m ({starts.separation_m:g}){depth}"
    )
