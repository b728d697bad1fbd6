"""
The layout of little-endian CDR, for code that writes and reads messages as bytes.

Numbers are aligned to their size, counted after the four bytes of the encapsulation. A text is its length in
bytes, including the final zero, then its bytes and the zero.
"""

from __future__ import annotations

import struct
from functools import cache

from auv_core.stamp import STAMP_BYTES, stamp_bytes

LITTLE_ENDIAN = b"\x00\x01"
"""First half of the encapsulation; readers skip the other half."""
ENCAPSULATION = LITTLE_ENDIAN + b"\x00\x00"
COUNT = struct.Struct("<I")
MOST_END_PADDING = 3
"""The network pads a message to a multiple of four bytes."""
STAMP_AT = len(ENCAPSULATION)
"""Offset of the stamp in a message that begins with a header."""
STAMP = slice(STAMP_AT, STAMP_AT + STAMP_BYTES)
_HEADER = struct.Struct("<4s8xI")
_ENCAPSULATION_SIZE = len(ENCAPSULATION)
_PADDING = [bytes(count) for count in range(8)]


class MalformedError(ValueError):
    """Raised for bytes that are not the expected message."""


def begun(frame_id: str, t_s: float) -> bytearray:
    """
    Return the beginning of a message up to its header, with the time `t_s` (s), padded for a number of eight
    bytes.
    """
    out = bytearray(_header(frame_id))
    out[STAMP] = stamp_bytes(t_s)
    return out


def aligned(place: int, size: int) -> int:
    """Return the first offset from `place` on at which a number of `size` bytes is aligned."""
    return place + (_ENCAPSULATION_SIZE - place) % size


def align(out: bytearray, size: int) -> None:
    """Pad a message so that a number of `size` bytes can follow."""
    out += _PADDING[(_ENCAPSULATION_SIZE - len(out)) % size]


def text_bytes(text: str) -> bytes:
    """Return the bytes of a text in a message, without its length."""
    return text.encode() + b"\0"


def read_text(data: bytes, at: int) -> str:
    """Return the text whose length is at an offset of a message."""
    return data[at + COUNT.size :].partition(b"\0")[0].decode(errors="replace")


def put_text(out: bytearray, text: str) -> None:
    """Append a text."""
    data = text_bytes(text)
    out += _PADDING[(_ENCAPSULATION_SIZE - len(out)) % COUNT.size]
    out += COUNT.pack(len(data))
    out += data


def body_at(data: bytes) -> int:
    """
    Return the offset of a number of eight bytes after the header of a message; raise as `header_end`.
    """
    return aligned(header_end(data), 8)


def header_end(data: bytes) -> int:
    """
    Return the offset of the first byte after the header of a message.

    Raises
    ------
    MalformedError
        If the bytes are no message with a header in little-endian CDR.

    """
    try:
        encapsulation, length = _HEADER.unpack_from(data)
    except struct.error:
        encapsulation, length = b"", 0
    if not encapsulation.startswith(LITTLE_ENDIAN) or length > len(data):
        raise MalformedError(f"{len(data)} bytes are not a message with a header in little-endian CDR")
    return _HEADER.size + length


@cache
def _header(frame_id: str) -> bytes:
    out = bytearray(ENCAPSULATION + bytes(STAMP_BYTES))
    put_text(out, frame_id)
    align(out, 8)
    return bytes(out)
