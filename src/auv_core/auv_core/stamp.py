"""A time as the eight bytes of a ROS stamp."""

from __future__ import annotations

import struct
from functools import lru_cache

_STAMP = struct.Struct("<iI")
STAMP_BYTES = _STAMP.size


@lru_cache(maxsize=16)
def stamp_bytes(t_s: float) -> bytes:
    """Return a time (s), to the nanosecond, as a serialised stamp; a tick has many messages of one stamp."""
    nanoseconds = round(t_s * 1e9)
    return _STAMP.pack(nanoseconds // 1_000_000_000, nanoseconds % 1_000_000_000)


def read_stamp_s(data: bytes, at: int) -> float:
    """Return the stamp (s) at a place of serialised bytes."""
    seconds, nanoseconds = _STAMP.unpack_from(data, at)
    return float(seconds + 1e-9 * nanoseconds)
