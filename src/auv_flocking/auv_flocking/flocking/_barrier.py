"""
The barrier of `communication_aware` for another law: a velocity that keeps the distance to all neighbours and
obstacles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import entry
from auv_core.geometry import Vec3, limited
from auv_flocking.flocking._avoidance import obstacle_bound
from auv_flocking.flocking._correction import Gains, direction, neighbour_bound, outlook
from auv_flocking.flocking._half_spaces import into_half_spaces

Matrix = NDArray[np.float64]


@entry("TUPLE3(TUPLE3, TUPLE3, TUPLE3, float64[:, ::1], float64[:, ::1], TUPLE16)")
def held_apart(
    asked: Vec3, own: Vec3, flock: Vec3, rows: Matrix, obstacles: Matrix, numbers: tuple[float, ...]
) -> Vec3:
    """
    Return the velocity near `asked` that the barrier allows (m/s; NED; in the flock's frame).

    Parameters
    ----------
    asked : (3,) tuple
        Velocity of the law in the frame that moves with the flock (m/s; NED).
    own, flock : (3,) tuple
        Own position (m) and the flock's velocity (m/s; NED).
    rows, obstacles : (n, WIDTH), (k, 8) arrays
        The neighbours; the obstacles, see `_avoidance`.
    numbers : (16,) tuple
        `Gains`.

    """
    gains, n = Gains(*numbers), len(rows)
    half_spaces = np.empty((n + len(obstacles), 4))
    for k in range(len(half_spaces)):
        if k < n:
            view = outlook(rows[k], 0.0, own, flock, gains)
            normal, bound_mps = view.normal, neighbour_bound(view, gains)
        else:
            row = obstacles[k - n]
            normal, distance_m = direction(own, (float(row[0]), float(row[1]), float(row[2])))
            bound_mps = obstacle_bound(row, normal, distance_m, flock, gains)
        half_spaces[k, 0], half_spaces[k, 1], half_spaces[k, 2] = normal
        half_spaces[k, 3] = bound_mps
    return limited(into_half_spaces(asked, half_spaces), gains.correction_limit_mps)
