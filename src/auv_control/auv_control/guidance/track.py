"""
Tracks: horizontal paths of lines and arcs that are joined with equal tangents.

The path parameter s (m) is the arc length from the start. It is not wrapped: on a closed track it grows by
the length of the track with every round. On an open track the first and the last piece extend without end. A
lane is the parallel curve at an offset to starboard; it keeps the parameter of the track.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import entry, fastest, inlined, inner
from auv_core.geometry import Box, clipped

Floats = NDArray[np.float64]

_STEP_MAX_M = 5.0
_STEPS = 4
_CONVERGED_M = 1e-9
_LEAST_SLOPE = 0.2


class Piece(NamedTuple):
    """
    A line or an arc.

    Path parameter and position where it begins (m; NED), its course there (rad), its length (m) and its
    curvature (1/m, positive to starboard, 0 for a line).
    """

    start_m: float
    north_m: float
    east_m: float
    course_rad: float
    length_m: float
    curvature_pm: float


class TrackPoint(NamedTuple):
    """Position (m; NED), course (rad) and curvature (1/m, positive to starboard) of a track at a point."""

    north_m: float
    east_m: float
    course_rad: float
    curvature_pm: float


class Offset(NamedTuple):
    """A position seen from a point of a track: ahead along the tangent, and to starboard of it (m)."""

    along_m: float
    across_m: float


@inlined
def point_on(piece: Piece, ahead_m: float) -> TrackPoint:
    """Return the point of a piece `ahead_m` after its start; the piece extends beyond both ends."""
    half_turn = 0.5 * piece.curvature_pm * ahead_m
    chord_m = ahead_m if half_turn == 0.0 else ahead_m * math.sin(half_turn) / half_turn
    towards = piece.course_rad + half_turn
    return TrackPoint(
        piece.north_m + chord_m * math.cos(towards),
        piece.east_m + chord_m * math.sin(towards),
        towards + half_turn,
        piece.curvature_pm,
    )


@inlined
def seen_from(point: TrackPoint, north_m: float, east_m: float) -> Offset:
    """Return a position (m; NED), seen from a point of a track."""
    dn, de = north_m - point.north_m, east_m - point.east_m
    c, s = math.cos(point.course_rad), math.sin(point.course_rad)
    return Offset(dn * c + de * s, de * c - dn * s)


@inlined
def newton_step(offset: Offset, curvature_pm: float) -> float:
    """
    Return the change of the path parameter (m) towards the point that is closest to a position.

    At the closest point the position is abeam, `along_m` = 0, and its derivative is -(1 - kappa `across_m`).
    The step is at most 5 m, so that the parameter is continuous also where a track meets itself.
    """
    slope = max(1.0 - curvature_pm * offset.across_m, _LEAST_SLOPE)
    return clipped(offset.along_m / slope, _STEP_MAX_M)


@inner
def piece_at(rows: Floats, round_m: float, s_m: float) -> int:
    """
    Return the index of the piece at a path parameter.

    Parameters
    ----------
    rows : (n, 6) array
        The pieces, each with the numbers of `Piece`.
    round_m : float
        Length of a round of a closed track (m), 0 for an open one.
    s_m : float
        Path parameter (m).

    """
    if round_m > 0.0:
        s_m %= round_m
    index = 0
    while index + 1 < len(rows) and rows[index + 1, 0] <= s_m:
        index += 1
    return index


@inner
def point_at(rows: Floats, round_m: float, index: int, s_m: float) -> TrackPoint:
    """Return the point of a piece at a path parameter (m); the other arguments as of `piece_at`."""
    row = rows[index]
    piece = Piece(float(row[0]), float(row[1]), float(row[2]), float(row[3]), float(row[4]), float(row[5]))
    if round_m > 0.0:
        s_m %= round_m
    return point_on(piece, s_m - piece.start_m)


@entry("Tuple((int64, float64))(float64[:, ::1], float64, float64, float64, float64)", allocates=False)
def followed(rows: Floats, round_m: float, s_m: float, north_m: float, east_m: float) -> tuple[int, float]:
    """
    Return the piece and the parameter (m) of the point closest to a position (m; NED), near the last
    parameter `s_m`; rows and round as of `piece_at`.

    It is found by Newton's method, so that the parameter is continuous while the vehicle moves.
    """
    for _ in range(_STEPS):
        point = point_at(rows, round_m, piece_at(rows, round_m, s_m), s_m)
        step_m = newton_step(seen_from(point, north_m, east_m), point.curvature_pm)
        s_m += step_m
        if abs(step_m) < _CONVERGED_M:
            break
    return piece_at(rows, round_m, s_m), s_m


class Track:
    """
    A track of pieces.

    `rows` are its pieces as an array, `round_m` its length if it is closed, else 0.

    Parameters
    ----------
    pieces : iterable of Piece
        In their order; see `joined`.
    is_closed : bool
        Whether the last piece ends where the first begins.

    """

    def __init__(self, pieces: Iterable[Piece], *, is_closed: bool) -> None:
        self.pieces = tuple(pieces)
        self.is_closed = is_closed
        self.length_m = self.pieces[-1].start_m + self.pieces[-1].length_m
        self.round_m = self.length_m if is_closed else 0.0
        self.rows: Floats = np.array(self.pieces)
        self._followed = fastest(followed)

    def piece_at(self, s_m: float) -> int:
        """Return the index of the piece at a path parameter (m)."""
        return piece_at(self.rows, self.round_m, s_m)

    def point(self, index: int, s_m: float) -> TrackPoint:
        """Return the point of a piece at a path parameter (m); the piece extends beyond both ends."""
        return point_at(self.rows, self.round_m, index, s_m)

    def at(self, s_m: float) -> TrackPoint:
        """Return the point at a path parameter (m)."""
        return self.point(self.piece_at(s_m), s_m)

    def followed(self, s_m: float, north_m: float, east_m: float) -> tuple[int, float]:
        """Return piece and parameter (m) of the point closest to a position (m; NED), near `s_m`."""
        return self._followed(self.rows, self.round_m, s_m, north_m, east_m)

    def closest(self, north_m: float, east_m: float) -> float:
        """Return the parameter (m) of the point of the whole track that is closest to a position (m; NED)."""
        return min(
            (math.hypot(*seen_from(point_on(piece, ahead_m), north_m, east_m)), piece.start_m + ahead_m)
            for piece in self.pieces
            for ahead_m in _candidates(piece, north_m, east_m)
        )[1]

    def curvatures(self) -> set[float]:
        """Return the curvatures of all pieces (1/m)."""
        return {piece.curvature_pm for piece in self.pieces}

    def box(self, first_m: float, last_m: float, depth_m: float) -> Box:
        """Return the smallest box around the track between two parameters (m), at a depth (m; NED)."""
        points = [self.at(s_m) for s_m in self._extremes(first_m, last_m)]
        norths, easts = [point.north_m for point in points], [point.east_m for point in points]
        return Box((min(norths), min(easts), depth_m), (max(norths), max(easts), depth_m))

    def _extremes(self, first_m: float, last_m: float) -> Iterator[float]:
        """Yield the ends, all joints between them, and where the course is along north or east."""
        yield from (first_m, last_m)
        rounds = range(int(first_m // self.length_m), int(last_m // self.length_m) + 1)
        for start_m in [k * self.length_m for k in rounds] if self.is_closed else [0.0]:
            for piece in self.pieces:
                turning = (piece.start_m + ahead_m for ahead_m in (0.0, *_turns_along_axes(piece)))
                yield from (start_m + s_m for s_m in turning if first_m <= start_m + s_m <= last_m)


def _candidates(piece: Piece, north_m: float, east_m: float) -> tuple[float, float, float]:
    """Return where on a piece the point closest to a position can be (m after its start)."""
    along_m, across_m = seen_from(point_on(piece, 0.0), north_m, east_m)
    if piece.curvature_pm == 0.0:
        abeam_m = along_m
    else:
        side = math.copysign(1.0, piece.curvature_pm)
        radius_m = abs(1.0 / piece.curvature_pm)
        turned = math.atan2(along_m, radius_m - side * across_m) % math.tau
        abeam_m = turned * radius_m
    return 0.0, min(max(abeam_m, 0.0), piece.length_m), piece.length_m


def _turns_along_axes(piece: Piece) -> Iterator[float]:
    """Yield where the course of an arc is north, east, south or west (m after its start)."""
    quarter = 0.5 * math.pi
    turn = piece.curvature_pm * piece.length_m
    low, high = sorted((piece.course_rad, piece.course_rad + turn))
    for k in range(math.ceil(low / quarter), math.floor(high / quarter) + 1):
        if piece.curvature_pm != 0.0:
            yield (k * quarter - piece.course_rad) / piece.curvature_pm


def joined(
    start: TrackPoint, lengths_and_curvatures: Iterable[tuple[float, float]], *, is_closed: bool
) -> Track:
    """
    Return a track of pieces with the given lengths (m) and curvatures (1/m), joined with equal tangents.

    Raises
    ------
    ValueError
        If a closed track does not end where it begins.

    """
    pieces: list[Piece] = []
    s_m = 0.0
    for length_m, curvature_pm in lengths_and_curvatures:
        pieces.append(Piece(s_m, start.north_m, start.east_m, start.course_rad, length_m, curvature_pm))
        s_m += length_m
        start = point_on(pieces[-1], length_m)
    gap_m = math.hypot(start.north_m - pieces[0].north_m, start.east_m - pieces[0].east_m)
    if is_closed and gap_m > 1e-6 * s_m:
        raise ValueError(f"pieces: a gap of {gap_m:.3g} m is not allowed; allowed: a closed track")
    return Track(pieces, is_closed=is_closed)


def legs(corners: Iterable[tuple[float, float]]) -> Track:
    """Return straight pieces from corner to corner (m; NED north, east); their tangents differ."""
    pieces: list[Piece] = []
    s_m = 0.0
    for (north_m, east_m), (next_north_m, next_east_m) in pairwise(corners):
        dn, de = next_north_m - north_m, next_east_m - east_m
        pieces.append(Piece(s_m, north_m, east_m, math.atan2(de, dn), math.hypot(dn, de), 0.0))
        s_m += pieces[-1].length_m
    return Track(pieces, is_closed=False)
