"""
Messages of which only the stamp and the numbers at the end change, written and read as bytes.

Filling in numbers at known places takes a microsecond; making the message, setting its fields and
serialising it takes fifty. What is published is the same: a test deserialises it.
"""

from __future__ import annotations

import struct
from functools import lru_cache
from typing import Any

from rclpy.serialization import serialize_message

_STAMP = struct.Struct("<iI")
_LENGTH = struct.Struct("<I")
_HEADER_STAMP_AT = 4
_FRAME_ID_AT = 16
_LITTLE_ENDIAN_CDR = b"\x00\x01"


@lru_cache(maxsize=16)
def _stamp_bytes(t_s: float) -> bytes:
    """Return a time (s), to the nanosecond, as a serialised stamp; a tick has many messages of one stamp."""
    nanoseconds = round(t_s * 1e9)
    return _STAMP.pack(nanoseconds // 1_000_000_000, nanoseconds % 1_000_000_000)


class Stencil:
    """
    The bytes of a message whose text and lists do not change.

    Parameters
    ----------
    message : ROS message
        With its frame ids; its numbers do not matter.
    numbers : str
        Layout of the numbers at the end of the serialised message, in the words of `struct`, without padding
        of its own.
    stamp_at : int
        Place of the stamp in the serialised message (bytes); behind the encapsulation where a header comes
        first.

    """

    def __init__(self, message: Any, numbers: str, *, stamp_at: int = _HEADER_STAMP_AT) -> None:
        self._bytes = bytearray(serialize_message(message))
        self._numbers = struct.Struct("<" + numbers)
        self._numbers_at = len(self._bytes) - self._numbers.size
        self._stamp = slice(stamp_at, stamp_at + _STAMP.size)

    def filled(self, t_s: float, *numbers: float) -> bytes:
        """Return the message with a stamp (s, to the nanosecond) and its numbers, ready to be published."""
        self._bytes[self._stamp] = _stamp_bytes(t_s)
        self._numbers.pack_into(self._bytes, self._numbers_at, *numbers)
        return bytes(self._bytes)


def read_numbers(data: bytes, layout: struct.Struct) -> tuple[Any, ...]:
    """
    Return the numbers at the end of a serialised message.

    Raises
    ------
    ValueError
        For bytes that are too short or not little-endian.

    """
    if data[:2] != _LITTLE_ENDIAN_CDR or len(data) < _HEADER_STAMP_AT + layout.size:
        raise ValueError(f"{len(data)} bytes that are not such a message in little-endian CDR")
    return layout.unpack_from(data, len(data) - layout.size)


def content_at(data: bytes) -> int:
    """
    Return where the content of a message begins whose header is followed by a number of eight bytes.

    Raises
    ------
    ValueError
        For bytes that are too short or not little-endian.

    """
    if data[:2] != _LITTLE_ENDIAN_CDR or len(data) < _FRAME_ID_AT:
        raise ValueError(f"{len(data)} bytes that are no message with a header in little-endian CDR")
    (length,) = _LENGTH.unpack_from(data, _FRAME_ID_AT - _LENGTH.size)
    end = _FRAME_ID_AT + int(length)
    return end + -(end - _HEADER_STAMP_AT) % 8


def read_stamp_s(data: bytes) -> float:
    """Return the stamp (s) of a serialised message that begins with a header."""
    seconds, nanoseconds = _STAMP.unpack_from(data, _HEADER_STAMP_AT)
    return float(seconds + 1e-9 * nanoseconds)
