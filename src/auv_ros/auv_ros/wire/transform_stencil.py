"""A message of transforms between fixed frames, filled in as bytes: only stamp and poses change."""

from __future__ import annotations

import struct
from collections.abc import Sequence

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Transform, TransformStamped, Vector3
from rclpy.serialization import serialize_message
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from auv_core.stamp import STAMP_BYTES, stamp_bytes

Pose = tuple[float, float, float, float, float, float, float]
"""Translation (m), quaternion with w last."""

_POSE = struct.Struct("<7d")
_STAMP_MARK = Time(sec=-1_234_567, nanosec=987_654_321)
_STAMP_MARK_BYTES = struct.pack("<iI", _STAMP_MARK.sec, _STAMP_MARK.nanosec)
_X_MARK = 1.25e300
_POSE_MARK_BYTES = struct.pack("<d", _X_MARK)


class TransformStencil:
    """
    The bytes of a tf2_msgs/TFMessage.

    Parameters
    ----------
    frames : sequence of (str, str)
        Parent and child of each transform.

    """

    def __init__(self, frames: Sequence[tuple[str, str]]) -> None:
        transforms = [
            TransformStamped(
                header=Header(stamp=_STAMP_MARK, frame_id=parent),
                child_frame_id=child,
                transform=Transform(translation=Vector3(x=_X_MARK)),
            )
            for parent, child in frames
        ]
        self._bytes = bytearray(serialize_message(TFMessage(transforms=transforms)))
        self._places: list[tuple[slice, int]] = []
        pose_at = 0
        for _ in frames:
            stamp_at = self._bytes.index(_STAMP_MARK_BYTES, pose_at)
            pose_at = self._bytes.index(_POSE_MARK_BYTES, stamp_at)
            self._places.append((slice(stamp_at, stamp_at + STAMP_BYTES), pose_at))

    def filled(self, t_s: float, poses: Sequence[Pose]) -> bytes:
        """Return the message with a stamp (s, to the nanosecond) and the pose of each child in its parent."""
        data, stamp = self._bytes, stamp_bytes(t_s)
        for (stamp_place, pose_at), pose in zip(self._places, poses, strict=True):
            data[stamp_place] = stamp
            _POSE.pack_into(data, pose_at, *pose)
        return bytes(data)
