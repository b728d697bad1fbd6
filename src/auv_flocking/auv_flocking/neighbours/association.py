"""
Association of sonar contacts with neighbours and other objects: gated, and one to one.

Only vehicles with a sonar import this module: the parts of SciPy that it needs take a third of a second to
load.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.special import gammaincinv

Matrix = NDArray[np.float64]

_FORBIDDEN = 1e6


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
) -> list[tuple[int, int]]:
    """
    Return pairs (contact, neighbour), by global nearest neighbour.

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

    """
    if len(points) == 0 or len(predicted) == 0:
        return []
    squared, likelihood = distances(points, noises, predicted, covariances)
    is_allowed = (squared <= gate) & (likelihood <= bound)
    rows, columns = linear_sum_assignment(np.where(is_allowed, likelihood, _FORBIDDEN))
    return [(int(i), int(j)) for i, j in zip(rows, columns, strict=True) if is_allowed[i, j]]


def distances(
    points: Matrix, noises: Matrix, predicted: Matrix, covariances: Matrix
) -> tuple[Matrix, Matrix]:
    """Return d^2 and d^2 + ln det S, each (m, n), of contacts and objects; arguments as in `associate`."""
    S = noises[:, None] + covariances[None]
    off = points[:, None] - predicted[None]
    squared = np.einsum("mni,mni->mn", off, np.linalg.solve(S, off[..., None])[..., 0])
    return squared, squared + np.linalg.slogdet(S)[1]
