"""RViz markers, all in map_ned: hulls, path, obstacles, flocking centres, acoustic links."""

from __future__ import annotations

import struct
from collections.abc import Sequence

from rclpy.serialization import serialize_message
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from auv_core.cdr import COUNT
from auv_core.geometry import Quat, Vec3
from auv_core.models import Handling
from auv_core.stamp import STAMP_BYTES, stamp_bytes
from auv_ros.wire.conversions import WORLD_FRAME, header, point, quaternion
from auv_ros.wire.stencil import Stencil

MARKER_TICKS = 5
STANDING_MARKER_TICKS = 50
"""Static markers (path, obstacles) are published again for viewers that start later; this is not urgent."""

_STAMP_AT = 8
_NOWHERE: Vec3 = (1.25e300, -2.5e300, 5e300)
Colour = tuple[float, float, float, float]
HULL: Colour = (0.95, 0.75, 0.1, 1.0)
LOST_HULL: Colour = (0.4, 0.4, 0.4, 1.0)
LINK: Colour = (0.2, 0.8, 0.9, 0.8)
OBSTACLE: Colour = (0.9, 0.3, 0.2, 1.0)
SENSED: Colour = (0.9, 0.6, 0.2, 0.25)
OBSTACLE_DIAMETER_M = 0.3
"""An obstacle is a point; it is drawn as a ball of this size."""


def sphere(
    namespace: str, number: int, t_s: float, centre: Vec3, diameter_m: float, colour: Colour
) -> Marker:
    """Return a sphere (m; NED)."""
    marker = _marker(namespace, number, t_s, Marker.SPHERE, colour)
    marker.pose.position = point(centre)
    marker.scale.x = marker.scale.y = marker.scale.z = diameter_m
    return marker


def sphere_stencil(namespace: str, number: int, diameter_m: float, colour: Colour) -> Stencil:
    """Return a MarkerArray of one sphere; fill it with its centre (m; NED)."""
    message = MarkerArray(markers=[sphere(namespace, number, 0.0, _NOWHERE, diameter_m, colour)])
    centre_at = bytes(serialize_message(message)).index(struct.pack("<3d", *_NOWHERE))
    return Stencil(message, "3d", stamp_at=_STAMP_AT, numbers_at=centre_at)


def hull_marker(
    namespace: str, t_s: float, pose: tuple[Vec3, Quat], handling: Handling, colour: Colour
) -> Marker:
    """Return a hull at a pose (m, NED; body FRD to NED): an ellipsoid along the body's forward axis."""
    marker = sphere(namespace, 0, t_s, pose[0], handling.hull_diameter_m, colour)
    marker.scale.x = handling.hull_length_m
    marker.pose.orientation = quaternion(pose[1])
    return marker


def hull_stencil(namespace: str, handling: Handling, colour: Colour) -> Stencil:
    """Return a MarkerArray of one hull; fill it with its centre (m; NED) and attitude (NED; w last)."""
    nowhere = (_NOWHERE, (1.0, 0.0, 0.0, 0.0))
    message = MarkerArray(markers=[hull_marker(namespace, 0.0, nowhere, handling, colour)])
    pose_at = bytes(serialize_message(message)).index(struct.pack("<3d", *_NOWHERE))
    return Stencil(message, "7d", stamp_at=_STAMP_AT, numbers_at=pose_at)


def removed(namespace: str, number: int, t_s: float) -> Marker:
    """Return the order to remove a marker."""
    marker = _marker(namespace, number, t_s, Marker.SPHERE, SENSED)
    marker.action = Marker.DELETE
    return marker


def lines(
    namespace: str, number: int, t_s: float, points: Sequence[Vec3], colour: Colour, *, joined: bool
) -> Marker:
    """Return a line through all points, or (not joined) one line per pair of points (m; NED)."""
    marker = _marker(namespace, number, t_s, Marker.LINE_STRIP if joined else Marker.LINE_LIST, colour)
    marker.scale.x = 0.03
    marker.points = [point(p) for p in points]
    return marker


class LineList:
    """
    A MarkerArray with one line per pair of points; only the stamp and the points change.

    Parameters
    ----------
    namespace, number, colour
        Those of the marker.

    """

    def __init__(self, namespace: str, number: int, colour: Colour) -> None:
        marker = lines(namespace, number, 0.0, [_NOWHERE], colour, joined=False)
        data = bytes(serialize_message(MarkerArray(markers=[marker])))
        point_bytes = struct.pack("<3d", *_NOWHERE)
        points_at = data.index(point_bytes)
        stamp_end = _STAMP_AT + STAMP_BYTES
        self._begin = data[:_STAMP_AT]
        self._middle = data[stamp_end : points_at - COUNT.size]
        self._end = data[points_at + len(point_bytes) :]

    def filled(self, t_s: float, points: Sequence[Vec3]) -> bytes:
        """Return the message with a stamp (s) and points (m; NED), ready to be published."""
        numbers = [number for point in points for number in point]
        return b"".join(
            (
                self._begin,
                stamp_bytes(t_s),
                self._middle,
                COUNT.pack(len(points)),
                struct.pack(f"<{len(numbers)}d", *numbers),
                self._end,
            )
        )


def _marker(namespace: str, number: int, t_s: float, kind: int, colour: Colour) -> Marker:
    marker = Marker(header=header(t_s, WORLD_FRAME), ns=namespace, id=number, type=kind, action=Marker.ADD)
    marker.pose.orientation.w = 1.0
    marker.color = ColorRGBA(r=colour[0], g=colour[1], b=colour[2], a=colour[3])
    return marker
