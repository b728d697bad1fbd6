"""
Messages in which only the stamp and some numbers change, written and read as bytes.

To fill in numbers at known offsets takes one microsecond; to make the message, set its fields and serialise
it takes fifty. The published message is the same: a test deserialises it.
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
        Message with its frame ids; its numbers are overwritten.
    numbers : str
        `struct` format of the numbers that change, without padding.
    stamp_at : int
        Offset of the stamp in the serialised message (bytes); after the encapsulation if the header comes
        first.
    numbers_at : int, optional
        Offset of the numbers (bytes); by default at the end of the message.

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
    Return the numbers of a serialised message that consists of a header and these numbers.

    Raises
    ------
    MalformedError
        If the bytes are not such a message.

    """
    at = body_at(data)
    if not 0 <= len(data) - at - layout.size <= MOST_END_PADDING:
        raise MalformedError(f"message has {len(data)} bytes; expected {at + layout.size}")
    return layout.unpack_from(data, at)


def header_stamp_s(data: bytes) -> float:
    """Return the stamp (s) of a serialised message; raise `MalformedError` for one without a header."""
    body_at(data)
    return read_stamp_s(data, STAMP_AT)
