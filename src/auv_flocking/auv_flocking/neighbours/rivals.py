"""Sonar contacts of one ping: what else may have caused them, and what the neighbours leave of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from auv_flocking.neighbours.sonar_contact import Sighting

Matrix = NDArray[np.float64]


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


def leftovers(
    sightings: Sequence[Sighting],
    pairs: list[tuple[int, int]],
    doubtful: list[int],
    points: Matrix,
    covariances: Matrix,
) -> Leftovers:
    """
    Return what the pairs of `associate` leave to objects after the n neighbours, (n, 3), (n, 3, 3).

    Doubtful contacts belong to something known, and begin no track.
    """
    n, owners = len(points), dict(pairs)
    is_seen = np.zeros(n, dtype=np.bool_)
    is_seen[[owner for owner in owners.values() if owner < n]] = True
    return Leftovers(
        [(sightings[contact], owner - n) for contact, owner in pairs if owner >= n],
        [seen for contact, seen in enumerate(sightings) if contact not in owners and contact not in doubtful],
        points,
        covariances,
        is_seen,
    )
