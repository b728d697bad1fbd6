"""A message of transforms between fixed frames, filled in as bytes: stamp and poses are all that changes."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from itertools import chain

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
        data = bytes(serialize_message(TFMessage(transforms=transforms)))
        self._texts: list[tuple[bytes, bytes]] = []
        layout, at = "<", 0
        for _ in frames:
            stamp_at = data.index(_STAMP_MARK_BYTES, at)
            frames_at = stamp_at + STAMP_BYTES
            pose_at = data.index(struct.pack("<d", _X_MARK), frames_at)
            self._texts.append((data[at:stamp_at], data[frames_at:pose_at]))
            layout += f"{stamp_at - at}s{STAMP_BYTES}s{pose_at - frames_at}s7d"
            at = pose_at + _POSE.size
        self._pack = struct.Struct(layout).pack

    def filled(self, t_s: float, poses: Sequence[Pose]) -> bytes:
        """Return the message with a stamp (s, to the nanosecond) and the pose of each child in its parent."""
        stamp = stamp_bytes(t_s)
        parts = (
            (before, stamp, names, *pose) for (before, names), pose in zip(self._texts, poses, strict=True)
        )
        return self._pack(*chain.from_iterable(parts))
