"""
Obstacle avoidance in the horizontal plane by a potential, thesis Eqs. (2.19)-(2.20).

    U(r) = k (ln(r^2 / d^2) + d^2 / r^2 - 1),     F = -grad U = 2 k (p - p_o) (d^2 - r^2) / r^4

with r the horizontal distance to the obstacle and d its safety distance. F points away from the obstacle for
r < d and is zero at r = d. For r > d it points towards the obstacle and decays as 2 k / r.

Deviation: (2.19) is not clearly legible; this is the form whose gradient is (2.20). The constant -1 makes
U(d) = 0, its smallest value. The gain k (N m) is ours; the thesis has none, that is k = 1 N m. The text
mentions repulsion only, so `truncate` can set U and F to zero beyond d; the thesis's form keeps them.
"""

from __future__ import annotations

import math

from auv_core.geometry import Vec3

Obstacles = tuple[tuple[Vec3, float], ...]

_NO_DIRECTION_M2 = 1e-18


def obstacle_potential(position: Vec3, obstacles: Obstacles, gain_nm: float, *, truncate: bool) -> float:
    """
    Return the potential of all obstacles together (J), infinite on an obstacle.

    Parameters
    ----------
    position : (3,) tuple
        Position of the vehicle (m; NED); its depth has no effect.
    obstacles : tuple of ((3,) tuple, float)
        Positions (m; NED) with their safety distances d (m).
    gain_nm : float
        Factor k (N m).
    truncate : bool
        Whether the potential is zero beyond d.

    """
    total = 0.0
    for centre, safety_m in obstacles:
        dx, dy = position[0] - centre[0], position[1] - centre[1]
        square = dx * dx + dy * dy
        limit = safety_m * safety_m
        if truncate and square >= limit:
            continue
        if square < _NO_DIRECTION_M2:
            return math.inf if gain_nm > 0.0 else 0.0
        total += math.log(square / limit) + limit / square - 1.0
    return gain_nm * total


def obstacle_force(
    position: Vec3, obstacles: Obstacles, gain_nm: float, *, truncate: bool
) -> tuple[float, float]:
    """
    Return the force of all obstacles together (N; north and east), thesis Eq. (2.20).

    It is the negative gradient of `obstacle_potential` and takes the same arguments; an obstacle nearer than
    a nanometre has no direction and gives no force.
    """
    north_n = east_n = 0.0
    for centre, safety_m in obstacles:
        dx, dy = position[0] - centre[0], position[1] - centre[1]
        square = dx * dx + dy * dy
        limit = safety_m * safety_m
        if square < _NO_DIRECTION_M2 or (truncate and square >= limit):
            continue
        factor = 2.0 * gain_nm * (limit - square) / (square * square)
        north_n += factor * dx
        east_n += factor * dy
    return north_n, east_n
