"""
The thesis's flock as one system: flocking law ``potential`` and consensus filter ``thesis`` over arrays.

The arithmetic is that of the laws themselves, in the order in which one vehicle's agent would do it, so that
a compiled flock and agents that know everything give the same numbers.  A pair of vehicles is visited once:
what pushes one pushes the other the other way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import entry, fastest, inlined
from auv_core.geometry import Vec3, added
from auv_flocking.central import STRENGTH, Numbers, Strength, along
from auv_flocking.consensus.thesis import towards
from auv_flocking.flock_task import Obstacles
from auv_flocking.flocking.potential import asked, attraction

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

Arguments = tuple[Any, ...]

LAW = (
    f"float64[:, ::1], float64[::1], FUNCTION({STRENGTH}), float64[::1], FUNCTION({STRENGTH}), float64[::1], "
    "float64[:, ::1]"
)
FLOCK_RATES = (
    "void(float64[:, ::1], float64[:, ::1], float64[:, :, ::1], int64, int64[::1], boolean, "
    f"int64[::1], int64[::1], {LAW}, float64[:, ::1], float64[:, :, ::1], int64)"
)


@dataclass(frozen=True)
class FlockLaw:
    """
    The numbers of a flock's laws, in the order in which compiled functions take them.

    shares : (N, 2) array
        Per vehicle: gain towards the path (1/s) and share of the path's velocity.
    numbers : (7,) array
        Cohesion gain (1/s), bandwidth ratio, correction limit (m/s), spacing (m), distance from which on
        vehicles do not push each other (m), rate of the consensus filter (1/s) and its reach (m).
    strength, strength_numbers, obstacle_strength, obstacle_numbers
        Separation between vehicles, and from obstacles, of `auv_flocking.central`.
    obstacles : (M, 4) array
        Positions and safety distances (m; NED).

    """

    shares: Floats
    numbers: Floats
    strength: Strength
    strength_numbers: Numbers
    obstacle_strength: Strength
    obstacle_numbers: Numbers
    obstacles: Floats

    @property
    def arguments(self) -> Arguments:
        """Everything, for functions whose signature has `LAW`."""
        return (
            self.shares,
            self.numbers,
            self.strength,
            self.strength_numbers,
            self.obstacle_strength,
            self.obstacle_numbers,
            self.obstacles,
        )


def flock_law(
    laws: Sequence[Any], law_params: Any, separation: Any, consensus: Any, obstacles: Obstacles
) -> FlockLaw:
    """
    Return the numbers of a flock.

    Parameters
    ----------
    laws : sequence of N flocking.potential.Flocking
        The law of each vehicle, with the parameters `law_params`.
    separation, consensus
        A separation law with `strength`, and the filter ``thesis``.
    obstacles : sequence of (position, safety distance)
        Obstacles that every vehicle knows of (m; NED).

    """
    p = law_params
    reach_m = getattr(separation, "reach_m", None)
    push_m = np.inf if reach_m is None else reach_m(p.spacing_m)
    numbers = (
        p.cohesion_gain_ps, p.bandwidth_ratio, p.correction_limit_mps, p.spacing_m, push_m,
        consensus.rate_ps, consensus.reach_m,
    )  # fmt: skip
    return FlockLaw(
        shares=np.array([(law.path_gain_ps, law.feedforward_share) for law in laws]),
        numbers=np.array(numbers, dtype=np.float64),
        strength=fastest(separation.strength),
        strength_numbers=separation.numbers,
        obstacle_strength=fastest(getattr(separation, "obstacle_strength", separation.strength)),
        obstacle_numbers=getattr(separation, "obstacle_numbers", separation.numbers),
        obstacles=np.array([(*place, safe_m) for place, safe_m in obstacles]).reshape(-1, 4),
    )


@inlined
def vector(rows: Floats, i: int) -> Vec3:
    """Return the first three numbers of row `i`."""
    return (rows[i, 0], rows[i, 1], rows[i, 2])


@inlined
def put(rows: Floats, i: int, v: Vec3) -> None:
    """Write the first three numbers of row `i`."""
    rows[i, 0], rows[i, 1], rows[i, 2] = v[0], v[1], v[2]


@entry(FLOCK_RATES, allocates=False)
def flock_rates(
    points: Floats,
    centres: Floats,
    all_paths: Floats,
    row: int,
    path_of: Ints,
    is_listed: bool,
    first: Ints,
    partners: Ints,
    shares: Floats,
    numbers: Floats,
    strength: Strength,
    strength_numbers: Numbers,
    obstacle_strength: Strength,
    obstacle_numbers: Numbers,
    obstacles: Floats,
    velocities: Floats,
    all_rates: Floats,
    stage: int,
) -> None:
    """
    Write what the law asks of every vehicle into `velocities`, and the rates of the estimates into `rates`.

    Parameters
    ----------
    points, centres : (N, 3) arrays
        Positions of the vehicles and their estimates of the flocking centre (m; NED).
    all_paths, row : (R, P, 8) array, int
        Position (m; NED), velocity (m/s; NED) and first and last component of the attitude of each path at
        R instants, and which of them it is now.
    path_of : (N,) array of int64
        The path of each vehicle.
    is_listed, first, partners
        Whether near pairs are listed, and the list of `auv_core.pairs.near_pairs`; where they are not, every
        pair is looked at.
    shares, ..., obstacles
        `FlockLaw.arguments`.
    velocities : (N, 3) array
        Where to write the velocities over ground that the law asks for (m/s; NED).
    all_rates, stage : (4, N, 3) array, int
        Where to write the rates of the estimates (m/s; NED).

    """
    cohesion_gain_ps, bandwidth_ratio, correction_limit_mps, spacing_m = (
        numbers[0],
        numbers[1],
        numbers[2],
        numbers[3],
    )
    push_m2, rate_ps, talk_m2 = numbers[4] * numbers[4], numbers[5], numbers[6] * numbers[6]
    count, paths, rates = len(points), all_paths[row], all_rates[stage]
    for i in range(count):
        own, centre, path = vector(points, i), vector(centres, i), vector(paths, path_of[i])
        put(velocities, i, attraction(own, centre, path, cohesion_gain_ps, shares[i, 0]))
        put(rates, i, towards((0.0, 0.0, 0.0), own, centre))
    for i in range(count):
        own, centre = vector(points, i), vector(centres, i)
        velocity, pull = vector(velocities, i), vector(rates, i)
        begin, end = (first[i], first[i + 1]) if is_listed else (i + 1, count)
        for place in range(begin, end):
            j = partners[place] if is_listed else place
            other = vector(points, j)
            dx, dy, dz = own[0] - other[0], own[1] - other[1], own[2] - other[2]
            square_m2 = dx * dx + dy * dy + dz * dz
            if square_m2 < push_m2:
                push = along(own, other, spacing_m, strength, strength_numbers)
                velocity = added(velocity, push)
                put(velocities, j, added(vector(velocities, j), (-push[0], -push[1], -push[2])))
            if square_m2 < talk_m2:
                theirs = vector(centres, j)
                pull = towards(pull, theirs, centre)
                put(rates, j, towards(vector(rates, j), centre, theirs))
        for k in range(len(obstacles)):
            stone, safe_m = vector(obstacles, k), obstacles[k, 3]
            velocity = added(velocity, along(own, stone, safe_m, obstacle_strength, obstacle_numbers))
        number = path_of[i]
        ahead = (paths[number, 3], paths[number, 4], paths[number, 5])
        put(velocities, i, asked(velocity, ahead, shares[i, 1], bandwidth_ratio, correction_limit_mps))
        put(rates, i, (rate_ps * pull[0], rate_ps * pull[1], rate_ps * pull[2]))
