"""
Reference types: by which vehicles each slot of a formation steers, thesis Section 1.7.2.2.

    eta_d,i = w_i + sum_j W_ij (eta_j - w_j)

w are the offsets of the slots. W is row-stochastic; the leading slot l has its weight on the path. The types
are rows of W: ``leader`` W_il = 1, ``predecessor`` W_i,p(i) = 1, ``neighbour`` W_ij = 1/|N(i)|. A hybrid type
is a convex sum of them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from auv_control.formations.shapes import NO_SLOT, graph_neighbours

Floats = NDArray[np.float64]

TYPES = ("leader", "predecessor", "neighbour")
_SUM_TOLERANCE = 1e-9


class Weights(NamedTuple):
    """
    The references of all slots.

    others : (n, n) array
        W_ij, the weight of slot j in the desired pose of slot i.
    path : (n,) array
        The weight of the path. With `others`, each row sums to 1.

    """

    others: Floats
    path: Floats


def reference_weights(
    shares: Mapping[str, float],
    followed: Sequence[int],
    neighbours: Sequence[Sequence[int]] | None = None,
) -> Weights:
    """
    Return the weights of a reference type.

    Parameters
    ----------
    shares : mapping
        The share of each of `TYPES`; they sum to 1. One type with share 1 is a single reference type.
    followed : sequence of n int
        The predecessor of each slot, `NO_SLOT` for the leading one; see `shapes.predecessors`.
    neighbours : sequence of n sequences of int, optional
        The neighbours of each slot; without it those of the shape's graph.

    Raises
    ------
    ValueError
        For shares that are not of these types, are negative or do not sum to 1, and for slots that nothing
        connects with the path.

    """
    _check_shares(shares)
    count = len(followed)
    leading = followed.index(NO_SLOT)
    near = graph_neighbours(followed) if neighbours is None else neighbours
    others, path = np.zeros((count, count)), np.zeros(count)
    path[leading] = 1.0
    for slot in range(count):
        if slot == leading:
            continue
        others[slot, leading] += shares.get("leader", 0.0)
        others[slot, followed[slot]] += shares.get("predecessor", 0.0)
        if shares.get("neighbour", 0.0) and not near[slot]:
            raise ValueError(f"neighbours: none for slot {slot} is not allowed; allowed: at least one")
        for other in near[slot]:
            others[slot, other] += shares.get("neighbour", 0.0) / len(near[slot])
    weights = Weights(others, path)
    check_weights(weights)
    return weights


def check_weights(weights: Weights) -> None:
    """
    Refuse weights that lead no vehicle from the path to some slot.

    Raises
    ------
    ValueError
        If a weight is negative, a row does not sum to 1, or the graph of W has no spanning tree that begins
        at the path.

    """
    others, path = weights
    if (others < 0.0).any() or (path < 0.0).any():
        raise ValueError("weights: negative ones are not allowed; allowed: at least 0")
    sums = others.sum(axis=1) + path
    wrong = np.flatnonzero(np.abs(sums - 1.0) > _SUM_TOLERANCE)
    if wrong.size:
        raise ValueError(
            f"weights: a row {wrong[0]} that sums to {sums[wrong[0]]:g} is not allowed; allowed: rows that "
            "sum to 1"
        )
    reached = _reached(others, path)
    if not reached.all():
        raise ValueError(
            f"weights: slots {np.flatnonzero(~reached).tolist()} without a connection to the path are not "
            "allowed; allowed: a graph in which every slot is reached from the path"
        )


def is_look_ahead(weights: Weights) -> bool:
    """
    Return whether slots can be ordered so that each steers by earlier ones only, thesis Section 1.11.2.

    That is so if the graph of W has no circle: the slots that steer by known ones only are known next.
    """
    others = weights.others
    known = np.zeros(len(others), dtype=bool)
    for _ in range(len(others)):
        known |= ~((others > 0.0) & ~known).any(axis=1)
    return bool(known.all())


def _reached(others: Floats, path: Floats) -> NDArray[np.bool_]:
    reached = path > 0.0
    for _ in range(len(path)):
        reached = reached | ((others > 0.0) & reached).any(axis=1)
    return reached


def _check_shares(shares: Mapping[str, float]) -> None:
    unknown = [name for name in shares if name not in TYPES]
    if unknown:
        raise ValueError(f"references: {unknown[0]!r} is not allowed; allowed: {', '.join(TYPES)}")
    if min(shares.values(), default=0.0) < 0.0 or abs(sum(shares.values()) - 1.0) > _SUM_TOLERANCE:
        raise ValueError(
            f"references: the shares {dict(shares)!r} are not allowed; allowed: at least 0 each, 1 in sum"
        )
