"""
Shapes of a formation, thesis Fig. 1.4, and which slot follows which.

Offsets are (x, y, z) in the frame of the formation (m): x along the course, y to its right, z down. With the
spacing d, no two slots are closer than d.

    column          one behind the other
    line            abreast, at the sides of the leader in turn
    wedge           two lines backwards from the leader, at the half-angle to the course
    diamond         squares of four with a corner in front, one behind the other
    double_platoon  two columns beside each other

Deviation: the thesis draws four of the shapes and names the diamond only (Fig. 1.20); it gives no offsets.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from auv_core.geometry import Vec3, distance

LEAST_HALF_ANGLE_RAD = math.radians(30.0)
"""From here to 150 degrees the two lines of a wedge are nowhere closer than the spacing."""
NO_SLOT = -1
_TIE_RATIO = 1e-9

Slots = tuple[Vec3, ...]


def _rank(slot: int) -> int:
    """Return how many places a slot is from the leader if two lines begin there."""
    return (slot + 1) // 2


def _side(slot: int) -> float:
    """Return 1 for slots on the right (odd ones), -1 for those on the left."""
    return 1.0 if slot % 2 else -1.0


def _column(slot: int, spacing_m: float, half_angle_rad: float) -> Vec3:
    return (-slot * spacing_m, 0.0, 0.0)


def _line(slot: int, spacing_m: float, half_angle_rad: float) -> Vec3:
    return (0.0, _side(slot) * _rank(slot) * spacing_m, 0.0)


def _wedge(slot: int, spacing_m: float, half_angle_rad: float) -> Vec3:
    along_m = _rank(slot) * spacing_m
    return (-along_m * math.cos(half_angle_rad), _side(slot) * along_m * math.sin(half_angle_rad), 0.0)


def _diamond(slot: int, spacing_m: float, half_angle_rad: float) -> Vec3:
    square, corner = divmod(slot, 4)
    half_m = spacing_m / math.sqrt(2.0)
    front_m = -square * (2.0 * half_m + spacing_m)
    if corner in (1, 2):
        return (front_m - half_m, _side(corner) * half_m, 0.0)
    return (front_m - (2.0 * half_m if corner == 3 else 0.0), 0.0, 0.0)


def _double_platoon(slot: int, spacing_m: float, half_angle_rad: float) -> Vec3:
    return (-(slot // 2) * spacing_m, 0.5 * _side(slot) * spacing_m, 0.0)


_OFFSETS: dict[str, Callable[[int, float, float], Vec3]] = {
    "column": _column,
    "line": _line,
    "wedge": _wedge,
    "diamond": _diamond,
    "double_platoon": _double_platoon,
}
SHAPES = tuple(_OFFSETS)
NO_SHAPE = "none"
"""What settings say instead of a shape to switch to."""


def shape_slots(shape: str, count: int, spacing_m: float, half_angle_rad: float = math.pi / 4.0) -> Slots:
    """
    Return the offsets of all slots of a shape.

    Parameters
    ----------
    shape : str
        One of `SHAPES`.
    count : int
        Number of vehicles.
    spacing_m : float
        Distance d of neighbouring slots (m).
    half_angle_rad : float
        Angle between the course and each line of a wedge (rad); other shapes do not use it.

    Raises
    ------
    ValueError
        For an unknown shape, and for a half-angle at which the lines of a wedge would be closer than d.

    """
    if shape not in _OFFSETS:
        raise ValueError(f"shape: {shape!r} is not allowed; allowed: {', '.join(SHAPES)}")
    most_rad = math.pi - LEAST_HALF_ANGLE_RAD
    if shape == "wedge" and not LEAST_HALF_ANGLE_RAD - 1e-9 <= half_angle_rad <= most_rad + 1e-9:
        raise ValueError(
            f"half_angle_rad: {half_angle_rad!r} is not allowed; allowed: {LEAST_HALF_ANGLE_RAD:.4f} to "
            f"{most_rad:.4f} (30 to 150 degrees)"
        )
    return tuple(_OFFSETS[shape](slot, spacing_m, half_angle_rad) for slot in range(count))


def predecessors(slots: Sequence[Vec3], leading: int = 0) -> tuple[int, ...]:
    """
    Return the slot that each slot follows; the leading one follows none (`NO_SLOT`).

    The graph of the shape connects each slot with the nearest one that has a lower number, of equals the
    lowest. That is a tree. Each slot follows its neighbour on the way to the leading slot. With slot 0 in the
    lead it is the slot ahead in a column, and in a line, a wedge and a double platoon the one before it in
    the same line.
    """
    nearest = [NO_SLOT]
    for slot in range(1, len(slots)):
        ranges_m = [distance(slots[slot], other) for other in slots[:slot]]
        least_m = min(ranges_m)
        nearest.append(next(j for j, r in enumerate(ranges_m) if r <= least_m * (1.0 + _TIE_RATIO)))
    slot, follows = leading, NO_SLOT
    while slot != NO_SLOT:  # turn the edges on the way from the leading slot to slot 0
        nearest[slot], slot, follows = follows, nearest[slot], slot
    return tuple(nearest)


def graph_neighbours(followed: Sequence[int]) -> tuple[tuple[int, ...], ...]:
    """Return the neighbours of each slot in the graph of the shape, whose edges are (slot, predecessor)."""
    return tuple(
        tuple(j for j in range(len(followed)) if followed[j] == slot or followed[slot] == j)
        for slot in range(len(followed))
    )


def neighbours_within(slots: Sequence[Vec3], reach_m: float) -> tuple[tuple[int, ...], ...]:
    """Return the slots within reach of each slot, thesis Eq. (1.3); positions only, no angles."""
    return tuple(
        tuple(j for j, other in enumerate(slots) if j != slot and distance(own, other) < reach_m)
        for slot, own in enumerate(slots)
    )


def least_distance_m(slots: Sequence[Vec3]) -> float:
    """Return the smallest distance of two slots (m); inf for one slot."""
    return min(
        (distance(own, other) for slot, own in enumerate(slots) for other in slots[:slot]), default=math.inf
    )
