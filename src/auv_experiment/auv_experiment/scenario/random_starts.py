"""Random starts drawn with the seed: in a ball, apart from each other and below the surface."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from auv_core.geometry import Vec3, distance
from auv_core.params import ConfigError

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import RandomStarts, Scenario

_STARTS_STREAM = 2
_START_TRIES = 20_000


def with_starts(scenario: Scenario) -> Scenario:
    """Return the scenario with every start position given."""
    starts = scenario.random_starts
    if starts is None or all(vehicle.position_ned_m is not None for vehicle in scenario.vehicles):
        return scenario
    rng = np.random.default_rng(np.random.SeedSequence((scenario.seed, _STARTS_STREAM)))
    taken = [vehicle.position_ned_m for vehicle in scenario.vehicles if vehicle.position_ned_m is not None]
    vehicles = []
    for vehicle in scenario.vehicles:
        if vehicle.position_ned_m is None:
            position = _draw_start(rng, starts, taken)
            taken.append(position)
            vehicle = replace(vehicle, position_ned_m=position)
        vehicles.append(vehicle)
    try:
        return replace(scenario, vehicles=tuple(vehicles))
    except ValueError as error:
        raise ConfigError(f"scenario.{error}") from None


def _draw_start(rng: np.random.Generator, starts: RandomStarts, taken: Sequence[Vec3]) -> Vec3:
    for _ in range(_START_TRIES):
        offset = rng.uniform(-starts.radius_m, starts.radius_m, 3)
        x, y, z = (float(c + o) for c, o in zip(starts.centre_ned_m, offset, strict=True))
        inside = math.hypot(*offset) <= starts.radius_m and z >= starts.depth_min_m
        if inside and all(distance((x, y, z), other) >= starts.separation_m for other in taken):
            return (x, y, z)
    raise ConfigError(
        f"scenario.random_starts: no room for {len(taken) + 1} vehicles; "
        f"allowed: a larger radius_m ({starts.radius_m:g}), "
        f"a smaller separation_m ({starts.separation_m:g}) or a smaller depth_min_m ({starts.depth_min_m:g})"
    )
