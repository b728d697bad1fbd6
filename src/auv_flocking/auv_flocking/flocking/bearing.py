"""
A formation by bearings: every vehicle goes where the lines of its bearings to others meet.

    p_d = M^-1 sum_j P_j p_j,     P_j = 1 - g_j g_j^T,     M = sum_j P_j

g_j is the direction in which vehicle j belongs, seen from the own slot, turned with the course. j are the
leader and the vehicles in lower slots. Distances to them do not count: the formation has the size that the
first follower gives it, which keeps its displacement from the leader. All else is as in `displacement`.

Where all bearings lie on one line they fix no place. So shapes in which slots lie on one line with all lower
slots are refused; on the way between two shapes such a vehicle keeps its displacement from the leader.

Source: S. Zhao and D. Zelazo (2016), Bearing rigidity and almost global bearing-only formation stabilization,
IEEE Trans. Automatic Control 61(5): bearings and the projections P_j. Deviation: their law is the gradient
sum_j P_j (p_j - p), with a gain that depends on the number of neighbours; M^-1 makes it the same for all.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from auv_control.formations.frame import Course, Offset
from auv_control.formations.shapes import NO_SHAPE
from auv_core.geometry import Vec3
from auv_core.params import same
from auv_flocking.flocking import Member, View
from auv_flocking.flocking._formation import FormationLaw, FormationParams
from auv_flocking.neighbours.estimates import AGE, Estimates
from auv_flocking.separation import SeparationLaw

Floats = NDArray[np.float64]

_LEAST_EIGENVALUE = 0.02
"""Of M: two bearings that differ by some 11 degrees have it."""


@dataclass(frozen=True)
class Params(FormationParams):
    """Parameters as in `displacement`, but for the references: the leader and all lower slots."""

    shape: str = same(FormationParams, "shape", default="wedge")


class Flocking(FormationLaw):
    """The law of one vehicle."""

    def __init__(self, params: Params, separation: SeparationLaw, member: Member) -> None:
        for shape in (params.shape, params.next_shape):
            if shape != NO_SHAPE:
                _check_bearings(params, shape, member.fleet_size)
        super().__init__(params, separation, member)

    def target(
        self, view: View, estimates: Estimates, own: Offset, course: Course
    ) -> tuple[Vec3 | None, float]:
        """Return p_d (m; NED) and the mean age of the packets behind it (s)."""
        response_s, order = self._params.response_s, self.roster.order
        if self.leads:
            return self.path_target(view, own), response_s
        slots, leader = order.slots, order.leader
        mine = slots[self._member.address]
        known = [
            (index, address)
            for index, address in enumerate(estimates.addresses)
            if address == leader or slots.get(address, mine) < mine
        ]
        if not known:
            return None, response_s
        places, ages_s = estimates.positions(), estimates.column(AGE)
        age_s = max(sum(ages_s[index] for index, _ in known) / len(known), response_s)
        offsets = [self.offset(address, course).position for _, address in known]
        met = meeting_point(own.position, offsets, [places[index] for index, _ in known])
        if met is not None:
            return met, age_s
        x, y, z = (places[known[0][0]][axis] + own.position[axis] - offsets[0][axis] for axis in range(3))
        return (x, y, z), age_s


def meeting_point(own: Vec3, offsets: list[Vec3], places: list[Vec3]) -> Vec3 | None:
    """
    Return the point from which vehicles at `places` are in the directions of the formation (m; NED).

    Parameters
    ----------
    own, offsets : Vec3, list of Vec3
        World offsets of the own slot and of those of the others (m; NED).
    places : list of Vec3
        Where the others are (m; NED).

    Returns
    -------
    point : Vec3 or None
        None if the bearings lie on one line.

    """
    m, b = np.zeros((3, 3)), np.zeros(3)
    for offset, place in zip(offsets, places, strict=True):
        p = _projection(own, offset)
        m += p
        b += p @ place
    if np.linalg.eigvalsh(m)[0] < _LEAST_EIGENVALUE:
        return None
    x, y, z = np.linalg.solve(m, b).tolist()
    return (x, y, z)


def _projection(own: Vec3, offset: Vec3) -> Floats:
    """Return P = 1 - g g^T of the direction from one slot to another."""
    way = np.subtract(offset, own)
    return np.asarray(np.eye(3) - np.outer(way, way) / max(float(way @ way), 1e-12))


def _check_bearings(params: Params, shape: str, count: int) -> None:
    """Refuse a shape in which bearings do not fix every slot from the third on."""
    slots = params.slots(shape, count)
    for slot in range(2, count):
        m = sum(_projection(slots[slot], lower) for lower in slots[:slot])
        if np.linalg.eigvalsh(m)[0] < _LEAST_EIGENVALUE:
            raise ValueError(
                f"shape: {shape!r} is not allowed; allowed: shapes whose slots do not lie on one line, since "
                f"bearings do not fix slot {slot}"
            )
