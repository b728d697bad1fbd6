"""
A flock of any size in continuous time as one compiled loop: laws, vehicles and RK4 steps over arrays.

All laws are evaluated in each of the four stages of a step. If vehicles interact at short range only, near
pairs are kept in a list with a slightly larger range. The list is made again as soon as a vehicle has moved
by half of the margin, so that no interacting pair is ever missing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import entry, inlined, record
from auv_core.integrate import put_along, put_step
from auv_core.pairs import NEAR_PAIRS
from auv_experiment.inprocess.hull_lanes import LANES, VEHICLE_RATES, normalise
from auv_flocking.central import STRENGTH, Strength
from auv_flocking.flock_rates import FLOCK_RATES, Instant, LawNumbers, NearPairs, Paths, Scene

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
ListPairs = Callable[[Floats, float], tuple[Ints, Ints]]
Rates = Callable[..., None]

FEW = 32
SKIN = 0.1


@inlined
def lists_pairs(count: int, law: LawNumbers) -> bool:
    """Return whether a list of near pairs pays: many vehicles that interact at short range only."""
    return bool(count > FEW and max(law.push_m, law.talk_m) < math.inf)


@inlined
def _copy(rows: Floats, to: Floats) -> None:
    """Write `rows` into `to`."""
    for i in range(rows.shape[0]):
        for c in range(rows.shape[1]):
            to[i, c] = rows[i, c]


@inlined
def _put_points(motion: Floats, points: Floats) -> None:
    """Write the positions of the vehicles."""
    is_hull = motion.shape[1] > 3
    for i in range(len(points)):
        for axis in range(3):
            points[i, axis] = motion[i // LANES, i % LANES + axis * LANES] if is_hull else motion[i, axis]


@inlined
def _has_moved(points: Floats, listed_at: Floats, by_m: float) -> bool:
    """Return whether a vehicle is farther than `by_m` from its listed position, or has no position."""
    for i in range(len(points)):
        dx = points[i, 0] - listed_at[i, 0]
        dy = points[i, 1] - listed_at[i, 1]
        dz = points[i, 2] - listed_at[i, 2]
        if not dx * dx + dy * dy + dz * dz <= by_m * by_m:
            return True
    return False


@record("float64[:, ::1], float64[:, ::1], LawNumbers, float64[::1]")
class FleetState(NamedTuple):
    """
    State of a flock, and the parameters of its laws.

    motion : (N, 3) or (B, 256) array
        Positions of points (m; NED), or hulls as in `hull_lanes`; overwritten.
    centres : (N, 3) array
        The vehicles' estimates of the flocking centre (m; NED); overwritten.
    law, hull
        Parameters of the laws and of the hulls (`hull_lanes.Hull.numbers`; empty for points).

    """

    motion: Floats
    centres: Floats
    law: LawNumbers
    hull: Floats


@record("int64, int64, float64, Paths")
class Course(NamedTuple):
    """
    Duration and path of a flight.

    ticks, steps, dt_s
        Control periods, RK4 steps in each of them, and the length of a step (s).
    paths : Paths
        The paths of the vehicles at every half step, 2 * ticks * steps + 1 rows.

    """

    ticks: int
    steps: int
    dt_s: float
    paths: Paths


@record(", ".join(5 * ["float64[:, :, ::1]"]))
class FleetLog(NamedTuple):
    """
    Log of the ticks, including the first and the last.

    motion, centres, centre_rates : (ticks + 1, ...) arrays
        Motion, estimates and their rates.
    velocities : (ticks + 1, N, 3) array
        Velocities commanded by the law (m/s; NED).
    wrenches : (ticks + 1, B, 96) array
        Wrenches commanded by the controllers of hulls (N, N m; body).

    """

    motion: Floats
    centres: Floats
    centre_rates: Floats
    velocities: Floats
    wrenches: Floats


@entry(
    f"void(FUNCTION({NEAR_PAIRS}), FUNCTION({FLOCK_RATES}), FUNCTION({VEHICLE_RATES}), "
    f"FUNCTION({STRENGTH}), FUNCTION({STRENGTH}), FleetState, Course, FleetLog)"
)
def run_fleet(
    list_pairs: ListPairs,
    flock_rates: Rates,
    vehicle_rates: Rates,
    strength: Strength,
    obstacle_strength: Strength,
    fleet: FleetState,
    course: Course,
    log: FleetLog,
) -> None:
    """
    Fly a flock of N vehicles along its course.

    Parameters
    ----------
    list_pairs, flock_rates, vehicle_rates
        `near_pairs` or `no_pairs`, `auv_flocking.flock_rates`, `hull_rates` or `point_rates`.
    strength, obstacle_strength
        Functions of `auv_flocking.flock_rates.FlockLaw`.
    fleet : FleetState
        State of the flock; updated.
    course : Course
        Duration and path of a flight.
    log : FleetLog
        Output: log of the ticks.

    """
    motion, centres, law = fleet.motion, fleet.centres, fleet.law
    ticks, steps, dt_s = course.ticks, course.steps, course.dt_s
    count, rows, columns = len(course.paths.path_of), motion.shape[0], motion.shape[1]
    reach_m, is_listed = max(law.push_m, law.talk_m), lists_pairs(count, law)
    first, partners = np.zeros(0, np.int64), np.zeros(0, np.int64)
    listed_at = np.full((count, 3), math.inf)
    points, velocities = np.empty((count, 3)), np.empty((count, 3))
    there, there_centres = np.empty((rows, columns)), np.empty((count, 3))
    k, k_centres = np.zeros((4, rows, columns)), np.zeros((4, count, 3))
    paths, hull = course.paths, fleet.hull
    scene = Scene(points, there_centres, paths)
    wanted, wrenches = np.zeros((rows, 5 * LANES)), np.zeros((rows, 6 * LANES))
    for step in range(ticks * steps + 1):
        _copy(motion, there)
        _copy(centres, there_centres)
        for stage in range(4):
            if stage > 0:
                span_s = dt_s if stage == 3 else 0.5 * dt_s
                put_along(motion, span_s, k, stage - 1, there)
                put_along(centres, span_s, k_centres, stage - 1, there_centres)
            _put_points(there, points)
            if is_listed and _has_moved(points, listed_at, 0.5 * SKIN * reach_m):
                first, partners = list_pairs(points, (1.0 + SKIN) * reach_m)
                _copy(points, listed_at)
            now = Instant(2 * step + (stage + 1) // 2, stage)
            near = NearPairs(is_listed, first, partners)
            flock_rates(scene, near, now, law, strength, obstacle_strength, velocities, k_centres)
            vehicle_rates(there, velocities, paths, now, hull, wanted, wrenches, k)
            if stage == 0 and step % steps == 0:
                tick = step // steps
                _copy(motion, log.motion[tick])
                _copy(centres, log.centres[tick])
                _copy(k_centres[0], log.centre_rates[tick])
                _copy(velocities, log.velocities[tick])
                if columns > 3:
                    _copy(wrenches, log.wrenches[tick])
            if step == ticks * steps:
                return
        put_step(motion, dt_s, k)
        put_step(centres, dt_s, k_centres)
        if columns > 3:
            normalise(count, motion)
