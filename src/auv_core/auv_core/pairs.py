"""
Pairs of points that are near each other, by cell lists.

Space is divided into cubes slightly wider than the reach, so that a point's partners are in its own cube and
the 26 around it. Cubes are found by a hash of their three indices, and their points are in one sorted array:
time and memory grow with the number of points, however they are distributed. The result is ordered by the
points' numbers and does not depend on the cubes, so that sums over near pairs equal, to the last bit, sums
over all pairs.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import entry, inner

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NEAR_PAIRS = "UniTuple(int64[::1], 2)(float64[:, ::1], float64)"

_FARTHEST_CELL = 2**30
_PAIRS_PER_POINT = 16
_WIDER = 1.0 + 1e-6  # so that rounding cannot put two near points two cells apart


@inner
def _cell(x_m: float, width_m: float) -> int:
    """Return the index of a coordinate's cell, limited to the largest index, so that it cannot overflow."""
    cells = x_m / width_m
    if cells >= _FARTHEST_CELL:
        return _FARTHEST_CELL
    if cells > -_FARTHEST_CELL:
        return math.floor(cells)
    return -_FARTHEST_CELL


@inner
def _bucket(x: int, y: int, z: int, mask: int) -> int:
    """Return the bucket of a cell; other cells may share it."""
    return (x * 73856093 ^ y * 19349663 ^ z * 83492791) & mask


@inner
def _longer(row: Ints) -> Ints:
    """Return a copy with twice the capacity."""
    longer = np.empty(2 * len(row), np.int64)
    longer[: len(row)] = row
    return longer


@inner
def _cells(points: Floats, width_m: float) -> Ints:
    """Return the (N, 3) indices of the points' cells."""
    cells = np.empty((len(points), 3), np.int64)
    for i in range(len(points)):
        for axis in range(3):
            cells[i, axis] = _cell(points[i, axis], width_m)
    return cells


@inner
def _by_bucket(cells: Ints, mask: int) -> tuple[Ints, Ints]:
    """Return where the points of each bucket begin, and the points bucket by bucket, in ascending order."""
    count = len(cells)
    start = np.zeros(mask + 2, np.int64)
    for i in range(count):
        start[_bucket(cells[i, 0], cells[i, 1], cells[i, 2], mask) + 1] += 1
    for bucket in range(mask + 1):
        start[bucket + 1] += start[bucket]
    member = np.empty(count, np.int64)
    free = start[:-1].copy()
    for i in range(count):
        bucket = _bucket(cells[i, 0], cells[i, 1], cells[i, 2], mask)
        member[free[bucket]] = i
        free[bucket] += 1
    return start, member


@inner
def _are_near(points: Floats, i: int, j: int, reach_m: float) -> bool:
    """Return whether two points are nearer than `reach_m`."""
    dx = points[i, 0] - points[j, 0]
    dy = points[i, 1] - points[j, 1]
    dz = points[i, 2] - points[j, 2]
    return bool(dx * dx + dy * dy + dz * dz < reach_m * reach_m)


@inner
def _smaller_partners(points: Floats, reach_m: float) -> tuple[Ints, Ints]:
    """
    Return the partners i < j for one j after the other, with spare capacity at the end, and where those of
    each j end.
    """
    count = len(points)
    buckets = 8
    while buckets < 2 * count:
        buckets *= 2
    mask = buckets - 1
    cells = _cells(points, reach_m * _WIDER)
    start, member = _by_bucket(cells, mask)
    found = 0
    smaller = np.empty(_PAIRS_PER_POINT * count + 1, np.int64)
    ends = np.empty(count, np.int64)
    for j in range(count):
        for number in range(27):
            x = cells[j, 0] + number // 9 - 1
            y = cells[j, 1] + number // 3 % 3 - 1
            z = cells[j, 2] + number % 3 - 1
            bucket = _bucket(x, y, z, mask)
            for place in range(start[bucket], start[bucket + 1]):
                i = member[place]
                if i >= j:
                    break
                is_there = cells[i, 0] == x and cells[i, 1] == y and cells[i, 2] == z
                if is_there and _are_near(points, i, j, reach_m):
                    if found == len(smaller):
                        smaller = _longer(smaller)
                    smaller[found] = i
                    found += 1
        ends[j] = found
    return smaller, ends


@inner
def _turned_round(smaller: Ints, ends: Ints) -> tuple[Ints, Ints]:
    """Return the partners j > i of every i, as `near_pairs` does; they are in ascending order."""
    count = len(ends)
    found = ends[count - 1] if count else 0
    first = np.zeros(count + 1, np.int64)
    for place in range(found):
        first[smaller[place] + 1] += 1
    for i in range(count):
        first[i + 1] += first[i]
    partners = np.empty(found, np.int64)
    free = first[:-1].copy()
    begin = 0
    for j in range(count):
        for place in range(begin, ends[j]):
            i = smaller[place]
            partners[free[i]] = j
            free[i] += 1
        begin = ends[j]
    return first, partners


@entry(NEAR_PAIRS)
def near_pairs(points: Floats, reach_m: float) -> tuple[Ints, Ints]:
    """
    Return the pairs i < j of points nearer than `reach_m`.

    Parameters
    ----------
    points : (N, 3 or more) array
        Points in the first three columns (m).  A point that is not a number has no partners.
    reach_m : float
        Points at this distance or farther are no pair (m); finite and above zero.

    Returns
    -------
    first : (N + 1,) array of int64
        Where the partners of point i begin; they end where those of i + 1 begin.
    partners : (P,) array of int64
        The j of each pair, for one i after the other, in ascending order.

    """
    smaller, ends = _smaller_partners(points, reach_m)
    return _turned_round(smaller, ends)


@entry(NEAR_PAIRS)
def no_pairs(points: Floats, reach_m: float) -> tuple[Ints, Ints]:
    """Return no pairs at all, for loops that look at every pair and need no list."""
    return np.zeros(len(points) + 1, np.int64), np.zeros(0, np.int64)
