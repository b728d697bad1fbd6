"""Association of sonar contacts with neighbours and other objects: gated, and one to one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.special import gammaincinv

from auv_flocking.neighbours.sonar_contact import Sighting

Matrix = NDArray[np.float64]

_FORBIDDEN = 1e6


class Rivals(NamedTuple):
    """
    Objects beside the neighbours that a contact may come from.

    points, covariances : (k, 3), (k, 3, 3) array
        Where they are at the time of the contacts (m, m^2; NED).
    bound : float
        Largest d^2 + ln det S of a pair; beyond it an unknown object is the more likely source.
    """

    points: Matrix
    covariances: Matrix
    bound: float


NO_RIVALS = Rivals(np.empty((0, 3)), np.empty((0, 3, 3)), math.inf)


class Leftovers(NamedTuple):
    """
    What remains of the contacts of one ping after the neighbours took theirs.

    claimed : list of (Sighting, int)
        Contacts of rivals, each with the row of its rival.
    unclaimed : list of Sighting
        Contacts that belong to nothing known.
    points, covariances : (n, 3), (n, 3, 3) array
        The neighbours (m, m^2; NED).
    is_seen : (n,) array of bool
        Which of them took a contact.
    """

    claimed: list[tuple[Sighting, int]]
    unclaimed: list[Sighting]
    points: Matrix
    covariances: Matrix
    is_seen: NDArray[np.bool_]


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


def leftovers(
    sightings: Sequence[Sighting], pairs: list[tuple[int, int]], points: Matrix, covariances: Matrix
) -> Leftovers:
    """Return what the pairs of `associate` leave to objects after the n neighbours, (n, 3), (n, 3, 3)."""
    n, owners = len(points), dict(pairs)
    is_seen = np.zeros(n, dtype=np.bool_)
    is_seen[[owner for owner in owners.values() if owner < n]] = True
    return Leftovers(
        [(sightings[contact], owner - n) for contact, owner in pairs if owner >= n],
        [seen for contact, seen in enumerate(sightings) if contact not in owners],
        points,
        covariances,
        is_seen,
    )
