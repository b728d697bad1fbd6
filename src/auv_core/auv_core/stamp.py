"""A time as the eight bytes of a ROS stamp."""

from __future__ import annotations

import struct
from functools import lru_cache

STAMP_NUMBERS = struct.Struct("<iI")
"""Seconds and nanoseconds."""
STAMP_BYTES = STAMP_NUMBERS.size


@lru_cache(maxsize=16)
def stamp_bytes(t_s: float) -> bytes:
    """Return a time (s), to the nanosecond, as a serialised stamp; a tick has many messages of one stamp."""
    return STAMP_NUMBERS.pack(*divmod(nanoseconds(t_s), 1_000_000_000))


def nanoseconds(t_s: float) -> int:
    """Return a time (s) as whole nanoseconds."""
    return round(t_s * 1e9)


def whole_nanoseconds_s(t_s: float) -> float:
    """Return a time (s) rounded as in a message."""
    return nanoseconds(t_s) * 1e-9


def read_stamp_s(data: bytes, at: int) -> float:
    """Return the stamp (s) at an offset of serialised bytes."""
    seconds, nanoseconds = STAMP_NUMBERS.unpack_from(data, at)
    return float(seconds + 1e-9 * nanoseconds)
