"""
Paths on the map: tracks of lines and arcs, for guidance by line of sight and as references at a speed.

To add one, write one file with ``Params`` and ``Path(params)``, a `GuidancePath`. The file's name is its
``kind``.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

from auv_control.guidance.track import Track
from auv_core.contracts import class_of, fulfilled
from auv_core.params import Section


class Place(NamedTuple):
    """Where on a path a vehicle is: the index of the piece that it follows, and the path parameter (m)."""

    piece: int
    s_m: float


class GuidancePath(Protocol):
    """
    A path; `track` is its geometry, and `is_smooth` tells whether its pieces are joined with equal tangents.

    A path with corners decides itself when the vehicle goes over to the next piece.
    """

    track: Track
    is_smooth: bool

    def engage(self, north_m: float, east_m: float) -> Place:
        """Return where a vehicle at a position (m; NED) enters the path: at the closest point."""
        s_m = self.track.closest(north_m, east_m)
        return Place(self.track.piece_at(s_m), s_m)

    def follow(self, place: Place, north_m: float, east_m: float) -> Place:
        """Return the place of a vehicle that has moved to a position (m; NED) since `place`."""
        return Place(*self.track.followed(place.s_m, north_m, east_m))


def make_path(section: Section) -> GuidancePath:
    """Return the path of a section."""
    path: GuidancePath = fulfilled(class_of(__name__, section.kind, "Path")(section.params), GuidancePath)
    return path
