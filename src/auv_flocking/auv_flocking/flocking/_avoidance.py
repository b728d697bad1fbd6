"""
Obstacles of `communication_aware` in numbers: one row each, known ones first.

A row has the position (m; NED), the safety distance d_o (m), the velocity (m/s; NED) and the standard
deviation of the position (m). A known obstacle stays where it is: velocity and deviation are 0.

    d_k = d_o + min(k_s sigma_k, m)
    barrier:  n_k . (u - v_k) >= -alpha (r_k - D d_o / d - min(k_b sigma_k, m))

v_k is the obstacle's velocity; the other symbols are those of the law. A vehicle takes the whole of this
bound, where two vehicles take half of theirs each: an obstacle does not give way.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import inner
from auv_core.geometry import Vec3
from auv_flocking.trackers import Sensed

if TYPE_CHECKING:
    from auv_flocking.flocking._correction import Gains

Matrix = NDArray[np.float64]
Obstacles = tuple[tuple[Vec3, float], ...]

SAFETY, SPEED, SIGMA, WIDTH = 3, 4, 7, 8
"""First columns of a row's safety distance, velocity and deviation; length of a row."""


def known_rows(known: Obstacles) -> Matrix:
    """Return known obstacles as rows (k, WIDTH)."""
    rows = [(*position, safety_m, 0.0, 0.0, 0.0, 0.0) for position, safety_m in known]
    return np.array(rows, dtype=np.float64).reshape(-1, WIDTH)


def sensed_rows(sensed: Sensed) -> Matrix:
    """Return sensed obstacles as rows (k, WIDTH)."""
    rows = [(*each.position, each.safety_distance_m, *each.velocity, each.sigma_m) for each in sensed]
    return np.array(rows, dtype=np.float64).reshape(-1, WIDTH)


@inner
def obstacle_spacing_m(row: Matrix, gains: Gains) -> float:
    """Return the distance d_k at which an obstacle begins to repel (m)."""
    return float(row[SAFETY]) + min(gains.spacing_sigmas * float(row[SIGMA]), gains.widening_limit_m)


@inner
def barrier_margin_m(sigma_m: float, gains: Gains) -> float:
    """Return the distance by which a deviation widens the barrier (m)."""
    return min(gains.barrier_sigmas * sigma_m, gains.widening_limit_m)


@inner
def obstacle_bound(row: Matrix, normal: Vec3, distance_m: float, flock: Vec3, gains: Gains) -> float:
    """
    Return the smallest allowed velocity away from an obstacle (m/s), in the flock's frame.

    Parameters
    ----------
    row : (WIDTH,) array
        The obstacle.
    normal, distance_m : (3,) tuple, float
        Direction from the obstacle to the vehicle (NED), and their distance (m).
    flock : (3,) tuple
        The flock's velocity (m/s; NED).
    gains : Gains
        The law's parameters.

    """
    x, y, z = (
        flock[0] - float(row[SPEED]),
        flock[1] - float(row[SPEED + 1]),
        flock[2] - float(row[SPEED + 2]),
    )
    carried_mps = normal[0] * x + normal[1] * y + normal[2] * z
    margin_m = barrier_margin_m(float(row[SIGMA]), gains)
    keep_m = gains.barrier_distance_m * float(row[SAFETY]) / gains.spacing_m + margin_m
    return min(-gains.barrier_rate_ps * (distance_m - keep_m) - carried_mps, gains.correction_limit_mps)
