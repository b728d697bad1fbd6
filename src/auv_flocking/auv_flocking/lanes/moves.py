"""
Moves of a fleet of lanes from one shape to another, under way and at a time that all know.

Each vehicle takes the slot that makes the sum of squared distances smallest, and its slot moves there on a
quintic (thesis Section 1.10.3). No packet is needed: all slots move by the clock, so they stay apart by
d / sqrt(2) (`auv_control.formations.assignment`). A vehicle that cannot stop gets forward or back by its
speed alone, which lies between its least and its largest one. That takes minutes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from auv_control.formations.switching import Transition
from auv_core.geometry import Vec3

PEAK_RATIO = 15.0 / 8.0
"""Largest rate of a quintic, per mean rate."""
ASIDE_RATIO = 0.25
"""Largest speed across the path, per speed along it: 14 degrees."""
VERTICAL_MPS = 0.2


class Spare(NamedTuple):
    """Largest speeds of a slot relative to the formation: along the path, across it and in depth (m/s)."""

    along_mps: float
    across_mps: float
    vertical_mps: float = VERTICAL_MPS


def spare_of(speed_mps: float, least_mps: float, largest_mps: float) -> Spare:
    """
    Return the speeds of a move in a fleet (m/s).

    Half of what the limits of the speed leave: the other half is for coordination, and for the inner and
    outer lanes of curves.
    """
    return Spare(0.5 * min(speed_mps - least_mps, largest_mps - speed_mps), ASIDE_RATIO * speed_mps)


def ways(
    before: Sequence[Vec3], after: Sequence[Vec3], start_s: float, move_s: float
) -> tuple[Transition, ...]:
    """
    Return the way of each vehicle, in the order of addresses.

    Parameters
    ----------
    before, after : sequences of n slots
        Slots of the two shapes (m; along the course, to starboard, down); the vehicle with address a begins
        in slot a - 1.
    start_s, move_s : float
        When the move begins and how long it lasts (s).

    """
    from auv_control.formations.assignment import assigned_slots  # SciPy is slow to load

    taken = assigned_slots(before, after)
    return tuple(
        Transition(own, after[slot], start_s, move_s) for own, slot in zip(before, taken, strict=True)
    )


def least_move_s(way: Transition, spare: Spare) -> float:
    """Return the shortest duration of a way at which no speed exceeds its limit (s)."""
    sides = (abs(b - a) for a, b in zip(way.before, way.after, strict=True))
    return PEAK_RATIO * max(side_m / limit_mps for side_m, limit_mps in zip(sides, spare, strict=True))


def check_move(way: Transition, spare: Spare) -> None:
    """
    Refuse a move that a vehicle cannot keep up with.

    Raises
    ------
    ValueError
        If it is too short.

    """
    least_s = least_move_s(way, spare)
    if way.duration_s < least_s:
        raise ValueError(
            f"move_s: {way.duration_s!r} is not allowed; allowed: at least {least_s:.0f} s, in which a slot "
            f"moves no faster than {spare.along_mps:.3g} m/s along the path, {spare.across_mps:.3g} m/s "
            f"across it and {spare.vertical_mps:g} m/s in depth"
        )
