"""
The vehicles that do one task together, as one of them sees its neighbours.

A law counts the vehicles of its group only, by their rank: 1 for the lowest address, then 2, and so on. So a
law that takes slots, layers or priorities from addresses needs not know that other vehicles are in the water.
Those others have no part in the task and are kept clear of.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from auv_flocking.flocking import Member
from auv_flocking.heard import bit_of
from auv_flocking.neighbours.estimates import AGE, COVARIANCE, HEARD_MASK, Estimates, Neighbours
from auv_flocking.trackers import Sensed, SensedObstacle

_NONE = Estimates.of(())


class Group:
    """
    The group of one vehicle.

    Parameters
    ----------
    addresses : sequence of int
        Acoustic addresses of the group, the own one among them; empty: all vehicles.
    address : int
        The own address.
    fleet_size : int
        Number of vehicles in the water.

    Attributes
    ----------
    size : int
        Number of vehicles of the group.
    is_all : bool
        Whether that is all vehicles.

    """

    def __init__(self, addresses: Sequence[int], address: int, fleet_size: int) -> None:
        self._addresses = tuple(sorted(addresses)) or tuple(range(1, fleet_size + 1))
        self._own = address
        self.size = len(self._addresses)
        self.is_all = self.size == fleet_size
        self._rank_of = {each: rank for rank, each in enumerate(self._addresses, start=1)}
        self._bits = np.array([bit_of(each) for each in self._addresses], dtype=np.int64)
        self._rank_bits = np.array([bit_of(rank) for rank in self._rank_of.values()], dtype=np.int64)

    def member(self, *, is_leader: bool) -> Member:
        """Return the vehicle's place in its group."""
        return Member(is_leader, self._rank_of[self._own], self.size)

    def split(self, neighbours: Estimates) -> tuple[Estimates, Estimates]:
        """Return the neighbours of the group, with their ranks for addresses, and all others."""
        if self.is_all:
            return neighbours, _NONE
        inside = [address in self._rank_of for address in neighbours.addresses]
        return self._ranked(_chosen(neighbours, inside)), _chosen(neighbours, [not each for each in inside])

    def _ranked(self, mates: Estimates) -> Estimates:
        ranks = [self._rank_of[address] for address in mates.addresses]
        rows = mates.rows.copy()
        rows[:, HEARD_MASK] = self._mask_of_ranks(rows[:, HEARD_MASK].astype(np.int64), ranks)
        return Estimates(ranks, rows, mates.shared)

    def _mask_of_ranks(self, masks: NDArray[np.int64], speakers: list[int]) -> NDArray[np.int64]:
        """Return the masks of whom the speakers have heard, with a bit for each rank; see `heard`."""
        is_heard = (masks[:, np.newaxis] & self._bits) != 0
        is_other = np.array(speakers, dtype=np.int64)[:, np.newaxis] != np.arange(1, self.size + 1)
        heard = np.bitwise_or.reduce(np.where(is_heard & is_other, self._rank_bits, 0), axis=1)
        missing = np.bitwise_or.reduce(np.where(~is_heard & is_other, self._rank_bits, 0), axis=1)
        masked: NDArray[np.int64] = heard & ~missing
        return masked


def _chosen(neighbours: Estimates, which: list[bool]) -> Estimates:
    rows = np.flatnonzero(which).tolist()
    return Estimates(
        [neighbours.addresses[row] for row in rows],
        neighbours.rows[rows],
        [neighbours.shared[row] for row in rows],
    )


def as_obstacles(others: Neighbours, safety_distance_m: float) -> Sensed:
    """
    Return vehicles of other groups as obstacles that move, for a law that knows no other way to avoid them.

    Parameters
    ----------
    others : sequence of NeighbourEstimate
        Where they are estimated to be.
    safety_distance_m : float
        Distance at which to begin to avoid them (m).

    """
    estimates = Estimates.of(others)
    spread = estimates.rows[:, COVARIANCE:AGE].reshape(-1, 6, 6)[:, :3, :3]
    variances_m2 = np.linalg.eigvalsh(spread).max(axis=1, initial=0.0).tolist()
    return tuple(
        SensedObstacle(
            each.address, each.position, each.velocity, variance_m2**0.5, each.age_s, safety_distance_m
        )
        for each, variance_m2 in zip(estimates, variances_m2, strict=True)
    )
