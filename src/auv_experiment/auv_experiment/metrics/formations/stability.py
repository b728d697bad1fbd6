"""
Errors of a formation, and its stability along strings, over a mesh and from leader to followers.

Thesis Section 1.11. Arrays are (instant, vehicle, axis) in m, NED. `offsets` are the world offsets w of the
vehicles' slots, `followed` the index of the vehicle that each one follows, -1 for the leader, which follows
the path.

    E_l = |p_l - path - w_l|        E_i = |p_i - p_p(i) - (w_i - w_p(i))|

String and mesh stability are judged by ratios of these errors. A ratio to an error under `FLOOR_M` is left
out: what is left of a disturbance that has died out. Leader-to-formation stability is judged by own-target
errors z: how far the followers are from where those by which they steer would have them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from auv_experiment.metrics.finite import norm
from auv_experiment.recording import FloatArray

FLOOR_M = 1e-3
LEADER = -1


def formation_error_m(positions: FloatArray, offsets: FloatArray, leading: int = 0) -> FloatArray:
    """
    Return F = sqrt(mean_i |(p_i - p_l) - (w_i - w_l)|^2) at each instant (m); the leader counts in the mean.
    """
    errors = positions - offsets
    away: FloatArray = norm(errors - errors[:, leading : leading + 1])
    return np.asarray(np.sqrt(np.nanmean(np.square(away), axis=1)))


def spacing_errors_m(
    positions: FloatArray, path: FloatArray, offsets: FloatArray, followed: Sequence[int]
) -> FloatArray:
    """Return the spacing error E of every vehicle at each instant, (K, N) (m); `path` is (K, 3)."""
    errors = positions - offsets
    ahead = np.stack([path if other == LEADER else errors[:, other] for other in followed], axis=1)
    return norm(errors - ahead)


def sup(errors_m: FloatArray) -> FloatArray:
    """Return the largest error of every vehicle (m)."""
    largest: FloatArray = errors_m.max(axis=0)
    return largest


def root_of_integral(errors_m: FloatArray, step_s: float) -> FloatArray:
    """Return the L2 norm of every vehicle's error (m s^1/2), for instants that are `step_s` apart (s)."""
    norms: FloatArray = np.sqrt(np.square(errors_m).sum(axis=0) * step_s)
    return norms


def gains_along_string(sizes: FloatArray, followed: Sequence[int]) -> list[float]:
    """
    Return gamma_j = |E_j| / |E_p(j)| of the predecessor form, thesis Eq. (1.23), in the norm of `sizes`.

    Vehicles that follow the leader are left out: its error is that to the path, which is another one.
    """
    return [
        float(sizes[j] / sizes[ahead])
        for j, ahead in enumerate(followed)
        if ahead != LEADER and followed[ahead] != LEADER and sizes[ahead] >= FLOOR_M
    ]


def gains_from_leader(sizes: FloatArray, followed: Sequence[int]) -> list[float]:
    """Return |E_j| / |E_l| of the leader form, thesis Eq. (1.22), of every follower."""
    leading = list(followed).index(LEADER)
    if sizes[leading] < FLOOR_M:
        return []
    return [float(sizes[j] / sizes[leading]) for j, ahead in enumerate(followed) if ahead != LEADER]


def gains_over_layers(errors: FloatArray, ahead: Sequence[Sequence[int]]) -> list[float]:
    """
    Return the ratios of the largest spacing errors of one layer to those of the layer ahead, Eq. (1.25).

    Parameters
    ----------
    errors : (K, N, 3) array
        Positions minus world offsets (m).
    ahead : sequence of N sequences of int
        The vehicles that each one follows, none for the leader, and no circle. A vehicle is one layer behind
        the last of those that it follows.

    """
    layers = _layers(ahead)
    largest_m = [0.0] * (max(layers) + 1)
    for vehicle, others in enumerate(ahead):
        for other in others:
            size_m = float(norm(errors[:, vehicle] - errors[:, other]).max())
            largest_m[layers[vehicle]] = max(largest_m[layers[vehicle]], size_m)
    return [after / before for before, after in pairwise(largest_m[1:]) if before >= FLOOR_M]


def _layers(ahead: Sequence[Sequence[int]]) -> list[int]:
    layers = [0] * len(ahead)
    for _ in ahead:
        layers = [1 + max((layers[other] for other in others), default=-1) for others in ahead]
    return layers


def target_errors(errors: FloatArray, others: FloatArray) -> FloatArray:
    """
    Return z_i = e_i - sum_j W_ij e_j at each instant, (K, N, 3) (m), of errors e = p - w.

    `others` is W by vehicles, (N, N). The row of a leader, which has its weight on the path, is its own e.
    """
    return np.asarray(errors - np.einsum("ij,kjc->kic", others, errors))


def stacked_m(target: FloatArray, leading: int = 0) -> FloatArray:
    """Return |z| of all own-target errors but the leader's at each instant (m)."""
    return norm(np.delete(norm(target), leading, axis=1))


def settled_after_s(t_s: FloatArray, errors_m: FloatArray, tolerance_m: float) -> float:
    """
    Return the last time at which an error is larger than the tolerance (s); -inf if none is.

    An error that is too large at the end settles never: inf.
    """
    out = np.flatnonzero((errors_m.reshape(len(t_s), -1) > tolerance_m).any(axis=1))
    if not out.size:
        return -math.inf
    return math.inf if out[-1] == len(t_s) - 1 else float(t_s[out[-1]])


def decay_rate_ps(t_s: FloatArray, sizes: FloatArray) -> float:
    """Return the rate of an exponential decay (1/s): the slope of the logarithm, by least squares."""
    slope, _ = np.polyfit(t_s, np.log(sizes), 1)
    return float(-slope)


def least_distance_m(positions: FloatArray) -> float:
    """Return the smallest distance of two vehicles at any of the instants (m); inf for one vehicle."""
    first, second = np.triu_indices(positions.shape[1], 1)
    if not first.size:
        return math.inf
    return float(norm(positions[:, first] - positions[:, second]).min())
