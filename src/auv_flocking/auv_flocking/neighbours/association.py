"""
Association of sonar contacts with neighbours and other objects: gated, and one to one.

Only vehicles with a sonar import this module: the parts of SciPy that it needs take a third of a second to
load.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.special import gammaincinv

Matrix = NDArray[np.float64]

_FORBIDDEN = 1e6


class Pairing(NamedTuple):
    """
    Which contact belongs to whom.

    pairs : pairs (contact, neighbour). doubtful : contacts that would have one, but another pairing is nearly
    as likely.
    """

    pairs: list[tuple[int, int]]
    doubtful: list[int]


def chi_square_gate(probability: float) -> float:
    """
    Return the squared Mahalanobis distance that a true contact (three numbers) does not exceed with this
    probability.
    """
    return float(2.0 * gammaincinv(0.5 * 3, probability))


def associate(
    points: Matrix,
    noises: Matrix,
    predicted: Matrix,
    covariances: Matrix,
    gate: float,
    bound: float = math.inf,
    margin: float = 0.0,
) -> Pairing:
    """
    Return the pairing by global nearest neighbour.

    Among all pairings with the largest possible number of pairs inside the gate, this is the one with the
    smallest sum of d^2 + ln det S, that is the most likely one. Contacts and neighbours outside every gate
    stay unpaired at no cost: a neighbour may be out of the sonar's range or missed, and a contact may be an
    unknown object.

    Parameters
    ----------
    points, noises : (m, 3), (m, 3, 3) array
        Contacts as points and their covariances (m, m^2; NED).
    predicted, covariances : (n, 3), (n, 3, 3) array
        Neighbours at the time of the contacts (m, m^2; NED).
    gate : float
        Largest squared Mahalanobis distance d^2.
    bound : float
        Largest d^2 + ln det S: a neighbour that may be anywhere claims no contact.
    margin : float
        A pair counts if every pairing without it, of as many pairs, has a sum that is larger by this.
        With -2 ln of odds of 100 to 1 it is 9.2; 0 takes the best pairing always.

    """
    if len(points) == 0 or len(predicted) == 0:
        return Pairing([], [])
    squared, likelihood = distances(points, noises, predicted, covariances)
    is_allowed = (squared <= gate) & (likelihood <= bound)
    costs = np.where(is_allowed, likelihood, _FORBIDDEN)
    rows, columns = linear_sum_assignment(costs)
    pairs = [(int(i), int(j)) for i, j in zip(rows, columns, strict=True) if is_allowed[i, j]]
    if margin == 0.0:
        return Pairing(pairs, [])
    least = float(costs[rows, columns].sum()) + margin
    doubtful = {
        i
        for i, j in pairs
        if is_allowed[i].sum() + is_allowed[:, j].sum() > 2 and _sum_without(costs, i, j) < least
    }
    return Pairing([pair for pair in pairs if pair[0] not in doubtful], sorted(doubtful))


def _sum_without(costs: Matrix, contact: int, neighbour: int) -> float:
    """Return the smallest sum of a pairing in which this pair is forbidden."""
    others = costs.copy()
    others[contact, neighbour] = _FORBIDDEN
    return float(others[linear_sum_assignment(others)].sum())


def distances(
    points: Matrix, noises: Matrix, predicted: Matrix, covariances: Matrix
) -> tuple[Matrix, Matrix]:
    """Return d^2 and d^2 + ln det S, each (m, n), of contacts and objects; arguments as in `associate`."""
    S = noises[:, None] + covariances[None]
    off = points[:, None] - predicted[None]
    squared = np.einsum("mni,mni->mn", off, np.linalg.solve(S, off[..., None])[..., 0])
    return squared, squared + np.linalg.slogdet(S)[1]
