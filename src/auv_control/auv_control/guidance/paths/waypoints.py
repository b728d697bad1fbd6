"""
Straight legs from waypoint to waypoint.

``corners: switched``: the vehicle goes over to the next leg when it is inside the circle of acceptance around
the waypoint (Fossen 2021, Handbook of Marine Craft Hydrodynamics and Motion Control, ch. 12); it overshoots
each corner by about its turning circle.  ``corners: rounded``: an arc inside each circle of acceptance joins
the legs with equal tangents, which lanes and references at a speed need.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from auv_control.guidance.paths import GuidancePath, Place
from auv_control.guidance.track import Piece, Track, TrackPoint, joined, legs, point_on, seen_from
from auv_core.geometry import smallest_angle
from auv_core.params import param

_STRAIGHT_RAD = 1e-9
_SHARPEST_RAD = math.radians(170.0)


@dataclass(frozen=True)
class Params:
    """Waypoints in their order, and what happens at the corners."""

    waypoints_ned_m: tuple[float, ...] = param(
        "waypoints, two numbers each: north and east (m; NED)",
        default=(0.0, 0.0, 200.0, 0.0, 200.0, 80.0, 0.0, 80.0),
        minimum=-1e5,
        maximum=1e5,
    )
    acceptance_m: float = param(
        "radius of the circle of acceptance around a waypoint (m)", default=25.0, above=0.0, maximum=1e5
    )
    corners: str = param(
        "whether the vehicle switches from leg to leg at corners, or arcs join the legs",
        default="rounded",
        choices=("rounded", "switched"),
    )

    def __post_init__(self) -> None:
        numbers = self.waypoints_ned_m
        if len(numbers) < 4 or len(numbers) % 2:
            raise ValueError(
                f"waypoints_ned_m: {len(numbers)} numbers are not allowed; allowed: two for each of at least "
                "two waypoints"
            )
        pieces = legs(self.corner_points).pieces
        for index, piece in enumerate(pieces, start=1):
            if piece.length_m <= 2.0 * self.acceptance_m:
                raise ValueError(
                    f"acceptance_m: {self.acceptance_m!r} is not allowed; allowed: less than half of every "
                    f"leg, of which number {index} has {piece.length_m:.4g} m"
                )
        for index, (leg, following) in enumerate(pairwise(pieces), start=1):
            turn = abs(smallest_angle(following.course_rad - leg.course_rad))
            if self.corners == "rounded" and turn > _SHARPEST_RAD:
                raise ValueError(
                    f"waypoints_ned_m: a turn of {math.degrees(turn):.0f} deg after leg {index} is not "
                    f"allowed; allowed: at most {math.degrees(_SHARPEST_RAD):.0f} deg if corners are rounded"
                )

    @property
    def corner_points(self) -> list[tuple[float, float]]:
        """The waypoints (m; NED north, east)."""
        numbers = self.waypoints_ned_m
        return list(zip(numbers[::2], numbers[1::2], strict=True))


class Path(GuidancePath):
    """Legs; an open path."""

    def __init__(self, params: Params) -> None:
        self._acceptance_m = params.acceptance_m
        self.is_smooth = params.corners == "rounded"
        self.track = legs(params.corner_points)
        if self.is_smooth:
            self.track = _rounded(self.track, params.acceptance_m)

    def engage(self, north_m: float, east_m: float) -> Place:
        """Return where a vehicle at a position (m; NED) enters the path; at corners that is the first leg."""
        if self.is_smooth:
            return super().engage(north_m, east_m)
        return _abeam(self.track, 0, north_m, east_m)

    def follow(self, place: Place, north_m: float, east_m: float) -> Place:
        """Return the place of a vehicle that has moved to a position (m; NED) since `place`."""
        if self.is_smooth:
            return super().follow(place, north_m, east_m)
        index = place.piece
        leg = self.track.pieces[index]
        left = seen_from(point_on(leg, leg.length_m), north_m, east_m)
        if math.hypot(*left) <= self._acceptance_m and index + 1 < len(self.track.pieces):
            index += 1
        return _abeam(self.track, index, north_m, east_m)


def _abeam(track: Track, index: int, north_m: float, east_m: float) -> Place:
    leg = track.pieces[index]
    return Place(index, leg.start_m + seen_from(point_on(leg, 0.0), north_m, east_m).along_m)


def _rounded(track: Track, acceptance_m: float) -> Track:
    """Return the track with an arc at each corner, from one edge of the circle of acceptance to the other."""
    first = track.pieces[0]
    start = TrackPoint(first.north_m, first.east_m, first.course_rad, 0.0)
    return joined(start, _legs_and_arcs(track.pieces, acceptance_m), is_closed=False)


def _legs_and_arcs(pieces: tuple[Piece, ...], acceptance_m: float) -> Iterator[tuple[float, float]]:
    cut_m = 0.0
    for leg, following in pairwise(pieces):
        turn = smallest_angle(following.course_rad - leg.course_rad)
        if abs(turn) < _STRAIGHT_RAD:
            yield leg.length_m - cut_m, 0.0
            cut_m = 0.0
            continue
        yield leg.length_m - cut_m - acceptance_m, 0.0
        curvature_pm = math.tan(0.5 * turn) / acceptance_m
        yield turn / curvature_pm, curvature_pm
        cut_m = acceptance_m
    yield pieces[-1].length_m - cut_m, 0.0
