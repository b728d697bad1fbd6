"""What a vehicle in a lane tells the others beside its position, as numbers that travel in every report."""

from __future__ import annotations

import enum
import math
from typing import NamedTuple

from auv_core.geometry import Vec3
from auv_flocking.codec import Field
from auv_flocking.neighbours.estimates import NeighbourEstimate

COURSES = 13
"""Courses among which a vehicle chooses to turn away."""
STRAIGHT_ON = COURSES // 2


class Mode(enum.IntEnum):
    """
    What a vehicle in a fleet of lanes does.

    TRANSIT: to its lane, in its layer. INLANE: in its lane, coordinated, in its layer. FORM: in its slot, at
    the depth of the formation. LEAVE: back to its layer, in its lane. LOITER: on a circle, in its layer.
    """

    TRANSIT = 0
    INLANE = 1
    FORM = 2
    LEAVE = 3
    LOITER = 4


FIELDS = (
    Field("gamma_m", -(2**21) * 0.05, 2**21 * 0.05, 0.05, wraps=True),
    Field("lane_reference_m", -(2**19) * 0.05, 2**19 * 0.05, 0.05, wraps=True),
    Field("lane_reference_rate_mps", -1.28, 1.27, 0.01),
    Field("lane_mode", 0, 7, 1),
    Field("is_limited", 0, 1, 1),
    Field("turn_away_course", 0, COURSES - 1, 1),
    Field("depth_target_m", 0.0, 511.5, 0.5),
)
"""The fields that a lane adds to a report, in the order of `LaneStatus`."""


class LaneStatus(NamedTuple):
    """
    The numbers of `FIELDS`.

    gamma_m : path parameter minus the offset of the own slot along the path (m).
    reference_m : reference r of the coordination law, so that gamma is to be v_L t + r (m).
    reference_rate_mps : rate of gamma - v_L t of a vehicle that cannot keep up (m/s).
    mode : `Mode`.
    is_limited : whether the vehicle cannot keep up.
    turn_away_course : which course it has turned to, 0 to 12; 6 is straight on.
    depth_target_m : depth to which it goes (m).
    """

    gamma_m: float
    reference_m: float
    reference_rate_mps: float
    mode: int
    is_limited: bool
    turn_away_course: int
    depth_target_m: float

    def numbers(self) -> tuple[float, ...]:
        """Return the numbers for a report."""
        return tuple(map(float, self))


class LaneNeighbour(NamedTuple):
    """
    A neighbour as its newest packet tells.

    address, time_s : its address, and the time tag of the packet (s). status : what it says; `gamma_m` and
    `reference_m` are the values nearest to the own ones. seen_s, position, velocity : the time at which the
    packet came (s), and the estimate at that time (m, m/s; NED).
    """

    address: int
    time_s: float
    status: LaneStatus
    seen_s: float
    position: Vec3
    velocity: Vec3


def neighbour(estimate: NeighbourEstimate, t_s: float, gamma_m: float, reference_m: float) -> LaneNeighbour:
    """
    Return a neighbour from its estimate when its packet comes.

    Parameters
    ----------
    estimate : NeighbourEstimate
        Whose shared numbers are those of a `LaneStatus`.
    t_s : float
        Time of the estimate (s).
    gamma_m, reference_m : float
        The own ones (m), to undo the wrapping of the neighbour's.

    Raises
    ------
    ValueError
        For another number of shared numbers.

    """
    if len(estimate.shared) != len(FIELDS):
        raise ValueError(f"a lane's report has {len(FIELDS)} shared numbers, this has {len(estimate.shared)}")
    numbers = LaneStatus(*estimate.shared)  # type: ignore[arg-type]
    status = LaneStatus(
        nearest(numbers.gamma_m, gamma_m, FIELDS[0]),
        nearest(numbers.reference_m, reference_m, FIELDS[1]),
        numbers.reference_rate_mps,
        int(numbers.mode),
        numbers.is_limited > 0,
        int(numbers.turn_away_course),
        numbers.depth_target_m,
    )
    return LaneNeighbour(estimate.address, estimate.time_s, status, t_s, estimate.position, estimate.velocity)


def nearest(value: float, to: float, field: Field) -> float:
    """Return the number that a field carries as `value` and that is nearest to another."""
    span = field.maximum - field.minimum
    return value + span * round((to - value) / span)


def apart_m(first_m: float, second_m: float, round_m: float) -> float:
    """Return the difference of two path parameters (m), the shortest if a round has `round_m` (0: open)."""
    difference_m = first_m - second_m
    if round_m > 0.0:
        return math.remainder(difference_m, round_m)
    return difference_m
