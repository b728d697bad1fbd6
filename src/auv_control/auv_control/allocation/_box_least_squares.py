"""
A strictly convex quadratic program within a box, by an active-set method.

    minimise  f^T H f / 2 - b^T f    subject to    lowest <= f <= highest

(Nocedal and Wright 2006, Numerical Optimization, algorithm 16.3, with bounds as the only constraints). Every
step lowers the objective from a feasible start, so the result is never worse than the start. Since a
thruster's limits are few, the free variables are found by a dense Cholesky decomposition.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import inlined, inner

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_MOST_STEPS_PER_VARIABLE = 10
_GRADIENT_TOLERANCE = 1e-13


@inner
def put_minimum(H: Floats, b: Floats, lowest: Floats, highest: Floats, f: Floats) -> None:
    """
    Move a feasible `f` to the minimum.

    Parameters
    ----------
    H, b : (n, n) and (n,) array
        Of the objective; H is positive definite.
    lowest, highest : (n,) array
        The box; where both are equal, the variable is fixed.
    f : (n,) array
        Start within the box; overwritten by the minimum.

    """
    n = len(f)
    held, free, factor = np.zeros(n, np.int64), np.zeros(n, np.int64), np.zeros((n, n))
    goal = np.zeros(n)
    for i in range(n):
        if f[i] <= lowest[i]:
            held[i] = -1
        elif f[i] >= highest[i]:
            held[i] = 1
    for _ in range(_MOST_STEPS_PER_VARIABLE * n):
        count = _put_free(held, free)
        _put_goal(H, b, f, free[:count], factor, goal)
        blocking = _move(f, free[:count], goal, lowest, highest)
        if blocking >= 0:
            held[blocking] = -1 if f[blocking] == lowest[blocking] else 1
            continue
        released = _worst_held(H, b, f, held, lowest, highest)
        if released < 0:
            return
        held[released] = 0


@inlined
def _put_free(held: Ints, free: Ints) -> int:
    """Write the indices of the variables that are not held; return their number."""
    count = 0
    for i in range(len(held)):
        if held[i] == 0:
            free[count] = i
            count += 1
    return count


@inner
def _put_goal(H: Floats, b: Floats, f: Floats, free: Ints, factor: Floats, goal: Floats) -> None:
    """Write into `goal` the minimum over the free variables, in their order, the others as they are."""
    count = len(free)
    for row in range(count):
        i = free[row]
        rest = b[i]
        for j in range(len(f)):
            rest -= H[i, j] * f[j]
        for column in range(count):
            rest += H[i, free[column]] * f[free[column]]
        for column in range(row):
            entry = H[i, free[column]]
            for k in range(column):
                entry -= factor[row, k] * factor[column, k]
            factor[row, column] = entry / factor[column, column]
            rest -= factor[row, column] * goal[column]
        pivot = H[i, i]
        for k in range(row):
            pivot -= factor[row, k] * factor[row, k]
        factor[row, row] = math.sqrt(pivot)
        goal[row] = rest / factor[row, row]
    for back in range(count):
        row = count - 1 - back
        for later in range(row + 1, count):
            goal[row] -= factor[later, row] * goal[later]
        goal[row] /= factor[row, row]


@inner
def _move(f: Floats, free: Ints, goal: Floats, lowest: Floats, highest: Floats) -> int:
    """Move the free variables to their goal or to the first limit; return which one met it, or -1."""
    share, blocking = 1.0, -1
    for row in range(len(free)):
        i = free[row]
        limit = lowest[i] if goal[row] < lowest[i] else highest[i]
        if lowest[i] <= goal[row] <= highest[i]:
            continue
        reached = (limit - f[i]) / (goal[row] - f[i])
        if reached < share or blocking < 0:
            share, blocking = reached, i
    for row in range(len(free)):
        i = free[row]
        f[i] = goal[row] if blocking < 0 else f[i] + share * (goal[row] - f[i])
        f[i] = min(max(f[i], lowest[i]), highest[i])
        if i == blocking:
            f[i] = lowest[i] if goal[row] < lowest[i] else highest[i]
    return blocking


@inner
def _worst_held(H: Floats, b: Floats, f: Floats, held: Ints, lowest: Floats, highest: Floats) -> int:
    """Return the held variable whose release lowers the objective most steeply, or -1."""
    worst, released = 0.0, -1
    for i in range(len(f)):
        if held[i] == 0 or lowest[i] == highest[i]:
            continue
        slope, size = -b[i], abs(b[i])
        for j in range(len(f)):
            slope += H[i, j] * f[j]
            size += abs(H[i, j] * f[j])
        gain = slope * held[i]
        if gain > _GRADIENT_TOLERANCE * size and gain > worst:
            worst, released = gain, i
    return released
