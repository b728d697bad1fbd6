"""
Which vehicle takes which slot, with a bound on the distances on the way.

The sum of the squared distances is smallest (the Hungarian problem). Then two vehicles that go straight to
their slots, at the same share of the way at all times, are nowhere closer than d / sqrt(2), where d is the
smallest distance of two starts or of two slots (Turpin, Michael and Kumar, 2014, CAPT).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from auv_control.formations.shapes import least_distance_m
from auv_core.geometry import Vec3


def assigned_slots(starts: Sequence[Vec3], slots: Sequence[Vec3]) -> tuple[int, ...]:
    """
    Return the slot of each vehicle.

    Parameters
    ----------
    starts, slots : sequences of n points
        Where the vehicles are and where the slots are, in one frame (m).

    """
    a, b = np.array(starts, dtype=np.float64), np.array(slots, dtype=np.float64)
    costs_m2 = np.square(a[:, None, :] - b[None, :, :]).sum(axis=-1)
    _, columns = linear_sum_assignment(costs_m2)
    return tuple(int(column) for column in columns)


def separation_bound_m(starts: Sequence[Vec3], slots: Sequence[Vec3]) -> float:
    """Return the distance that no two vehicles of an assignment fall below on their way (m)."""
    return min(least_distance_m(starts), least_distance_m(slots)) / math.sqrt(2.0)


def least_separation_m(starts: Sequence[Vec3], ends: Sequence[Vec3]) -> float:
    """
    Return the smallest distance of two vehicles that go straight from `starts` to `ends` (m).

    All have the same share of their way behind them at all times. Unlike `separation_bound_m` it is exact,
    and holds for any assignment.
    """
    a, b = np.array(starts, dtype=np.float64), np.array(ends, dtype=np.float64)
    first, second = np.triu_indices(len(a), 1)
    if not first.size:
        return math.inf
    begin = a[first] - a[second]
    change = b[first] - b[second] - begin
    square = np.square(change).sum(axis=1)
    along = -(begin * change).sum(axis=1)
    share = np.clip(np.divide(along, square, out=np.zeros_like(along), where=square > 0.0), 0.0, 1.0)
    return float(np.linalg.norm(begin + share[:, None] * change, axis=1).min())
