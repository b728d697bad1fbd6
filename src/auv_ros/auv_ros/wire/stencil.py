"""
Messages of which only the stamp and some numbers change, written and read as bytes.

Filling in numbers at known places takes a microsecond; making the message, setting its fields and
serialising it takes fifty. What is published is the same: a test deserialises it.
"""

from __future__ import annotations

import struct
from typing import Any

from rclpy.serialization import serialize_message

from auv_core.cdr import MOST_END_PADDING, STAMP_AT, MalformedError, body_at
from auv_core.stamp import STAMP_BYTES, read_stamp_s, stamp_bytes


class Stencil:
    """
    The bytes of a message whose text and lists do not change.

    Parameters
    ----------
    message : ROS message
        With its frame ids; its numbers do not matter.
    numbers : str
        Layout of the numbers that change, in the words of `struct`, without padding of its own.
    stamp_at : int
        Place of the stamp in the serialised message (bytes); behind the encapsulation where a header comes
        first.
    numbers_at : int, optional
        Place of the numbers (bytes); at the end of the message if left out.

    """

    def __init__(
        self, message: Any, numbers: str, *, stamp_at: int = STAMP_AT, numbers_at: int | None = None
    ) -> None:
        data = bytes(serialize_message(message))
        size = struct.calcsize("<" + numbers)
        stamp_end = stamp_at + STAMP_BYTES
        start = len(data) - size if numbers_at is None else numbers_at
        self._before = data[:stamp_at]
        self._between = data[stamp_end:start]
        self._after = data[start + size :]
        lengths = (stamp_at, STAMP_BYTES, len(self._between))
        layout = "".join(f"{length}s" for length in lengths) + f"{numbers}{len(self._after)}s"
        self._pack = struct.Struct("<" + layout).pack

    def filled(self, t_s: float, *numbers: float) -> bytes:
        """Return the message with a stamp (s, to the nanosecond) and its numbers, ready to be published."""
        return self._pack(self._before, stamp_bytes(t_s), self._between, *numbers, self._after)


def read_numbers(data: bytes, layout: struct.Struct) -> tuple[Any, ...]:
    """
    Return the numbers of a serialised message that has a header and, behind it, these numbers only.

    Raises
    ------
    MalformedError
        For bytes that are no such message.

    """
    at = body_at(data)
    if not 0 <= len(data) - at - layout.size <= MOST_END_PADDING:
        raise MalformedError(f"{len(data)} bytes where {at + layout.size} are such a message")
    return layout.unpack_from(data, at)


def header_stamp_s(data: bytes) -> float:
    """Return the stamp (s) of a serialised message; raise `MalformedError` for one without a header."""
    body_at(data)
    return read_stamp_s(data, STAMP_AT)
