"""
The thesis's flock as one system: flocking law ``potential`` and consensus filter ``thesis`` over arrays.

The arithmetic is that of the laws themselves, in the order of a single vehicle's agent, so that a compiled
flock and agents with perfect information give the same numbers. A pair of vehicles is visited once: the force
on one is the opposite of the force on the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import entry, fastest, inlined, record
from auv_core.geometry import Vec3, added
from auv_flocking.central import STRENGTH, Numbers, Strength, along
from auv_flocking.consensus.thesis import Consensus, towards
from auv_flocking.flock_task import Obstacles
from auv_flocking.flocking.potential import Flocking, Params, asked, attraction
from auv_flocking.separation import CentralLaw

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

KNOWS_PATH = -1

FLOCK_RATES = (
    f"void(Scene, NearPairs, Instant, LawNumbers, FUNCTION({STRENGTH}), FUNCTION({STRENGTH}), "
    "float64[:, ::1], float64[:, :, ::1])"
)


@record("float64[:, ::1], " + ", ".join(7 * ["float64"]) + ", float64[::1], float64[::1], float64[:, ::1]")
class LawNumbers(NamedTuple):
    """
    The parameters of a flock's laws.

    shares : (N, 2) array
        Per vehicle: gain towards the path (1/s) and share of the path's velocity.
    push_m, talk_m : float
        Distances beyond which vehicles do not repel each other, and do not hear each other's estimates (m).
    rate_ps : float
        Rate of the consensus filter (1/s).
    strength_numbers, obstacle_numbers : arrays
        Parameters of the separation between vehicles and from obstacles; see `auv_flocking.central`.
    obstacles : (M, 4) array
        Positions and safety distances (m; NED).

    """

    shares: Floats
    cohesion_gain_ps: float
    bandwidth_ratio: float
    correction_limit_mps: float
    spacing_m: float
    push_m: float
    rate_ps: float
    talk_m: float
    strength_numbers: Numbers
    obstacle_numbers: Numbers
    obstacles: Floats


@record("int64, int64")
class Instant(NamedTuple):
    """The current row of `Paths`, and the stage of an RK4 step."""

    row: int
    stage: int


@record("float64[:, :, ::1], int64[::1], int64[::1]")
class Paths(NamedTuple):
    """
    The paths of all vehicles.

    table : (R, P, 8) array
        Position (m; NED), velocity (m/s; NED) and first and last component of the attitude of each path at R
        instants.
    path_of : (N,) array of int64
        The path of each vehicle.
    guide_of : (N,) array of int64
        The vehicle whose heading each vehicle takes; `KNOWS_PATH`: none, it has that of its path.

    """

    table: Floats
    path_of: Ints
    guide_of: Ints


@record("boolean, int64[::1], int64[::1]")
class NearPairs(NamedTuple):
    """Whether near pairs are listed, and the list of `near_pairs`; if not, every pair counts."""

    is_listed: bool
    first: Ints
    partners: Ints


@record("float64[:, ::1], float64[:, ::1], Paths")
class Scene(NamedTuple):
    """Positions of the vehicles and their estimates of the centre, (N, 3) (m; NED), and their paths."""

    points: Floats
    centres: Floats
    paths: Paths


@dataclass(frozen=True)
class FlockLaw:
    """Parameters of the laws, and callable separation laws between vehicles and from obstacles."""

    numbers: LawNumbers
    strength: Strength
    obstacle_strength: Strength


def flock_law(
    laws: Sequence[Flocking],
    law_params: Params,
    separation: CentralLaw,
    consensus: Consensus,
    obstacles: Obstacles,
) -> FlockLaw:
    """
    Return the parameters of a flock.

    Parameters
    ----------
    laws : sequence of N flocking.potential.Flocking
        The law of each vehicle, with the parameters `law_params`.
    separation, consensus
        A separation law along the line between two, and the filter ``thesis``.
    obstacles : sequence of (position, safety distance)
        Obstacles that every vehicle knows of (m; NED).

    """
    p = law_params
    numbers = LawNumbers(
        shares=np.array([(law.path_gain_ps, law.feedforward_share) for law in laws]),
        cohesion_gain_ps=float(p.cohesion_gain_ps),
        bandwidth_ratio=float(p.bandwidth_ratio),
        correction_limit_mps=float(p.correction_limit_mps),
        spacing_m=float(p.spacing_m),
        push_m=float(separation.reach_m(p.spacing_m)),
        rate_ps=float(consensus.rate_ps),
        talk_m=float(consensus.reach_m),
        strength_numbers=separation.numbers,
        obstacle_numbers=separation.obstacle_numbers,
        obstacles=np.array([(*place, safe_m) for place, safe_m in obstacles]).reshape(-1, 4),
    )
    return FlockLaw(numbers, fastest(separation.strength), fastest(separation.obstacle_strength))


def guides(is_leader: Sequence[bool]) -> list[int]:
    """
    Return the vehicle whose heading each vehicle takes in continuous time, where all hear each other.

    A leader has the heading of its path (`KNOWS_PATH`), a follower that of the first leader. Without a leader
    it keeps its own.
    """
    first = list(is_leader).index(True) if any(is_leader) else None
    return [
        KNOWS_PATH if leads else (index if first is None else first) for index, leads in enumerate(is_leader)
    ]


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
    scene: Scene,
    near: NearPairs,
    now: Instant,
    law: LawNumbers,
    strength: Strength,
    obstacle_strength: Strength,
    velocities: Floats,
    all_rates: Floats,
) -> None:
    """
    Write the velocity commands of all vehicles into `velocities`, and the rates of the estimates into
    `rates`.

    Parameters
    ----------
    scene, near, now : Scene, NearPairs, Instant
        Inputs of the laws.
    law, strength, obstacle_strength
        Of `FlockLaw`.
    velocities : (N, 3) array
        Output: commanded velocities over ground (m/s; NED).
    all_rates : (4, N, 3) array
        Output: rates of the estimates (m/s; NED), by stage.

    """
    points, centres, obstacles = scene.points, scene.centres, law.obstacles
    paths, path_of, rates = scene.paths.table[now.row], scene.paths.path_of, all_rates[now.stage]
    push_m2, rate_ps, talk_m2 = law.push_m * law.push_m, law.rate_ps, law.talk_m * law.talk_m
    count = len(points)
    for i in range(count):
        own, centre, path = vector(points, i), vector(centres, i), vector(paths, path_of[i])
        put(velocities, i, attraction(own, centre, path, law.cohesion_gain_ps, law.shares[i, 0]))
        put(rates, i, towards((0.0, 0.0, 0.0), own, centre))
    for i in range(count):
        own, centre = vector(points, i), vector(centres, i)
        velocity, pull = vector(velocities, i), vector(rates, i)
        begin, end = (near.first[i], near.first[i + 1]) if near.is_listed else (i + 1, count)
        for place in range(begin, end):
            j = near.partners[place] if near.is_listed else place
            other = vector(points, j)
            dx, dy, dz = own[0] - other[0], own[1] - other[1], own[2] - other[2]
            square_m2 = dx * dx + dy * dy + dz * dz
            if square_m2 < push_m2:
                push = along(own, other, law.spacing_m, strength, law.strength_numbers)
                velocity = added(velocity, push)
                put(velocities, j, added(vector(velocities, j), (-push[0], -push[1], -push[2])))
            if square_m2 < talk_m2:
                theirs = vector(centres, j)
                pull = towards(pull, theirs, centre)
                put(rates, j, towards(vector(rates, j), centre, theirs))
        for k in range(len(obstacles)):
            stone, safe_m = vector(obstacles, k), obstacles[k, 3]
            push = along(own, stone, safe_m, obstacle_strength, law.obstacle_numbers)
            velocity = added(velocity, push)
        number = path_of[i]
        ahead = (paths[number, 3], paths[number, 4], paths[number, 5])
        share, ratio, limit_mps = law.shares[i, 1], law.bandwidth_ratio, law.correction_limit_mps
        put(velocities, i, asked(velocity, ahead, share, ratio, limit_mps))
        put(rates, i, (rate_ps * pull[0], rate_ps * pull[1], rate_ps * pull[2]))
