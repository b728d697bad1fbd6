"""
A message that ends with a list of records, filled from the rows of an array.

A record is an address (one byte) and a fixed number of float64. In CDR these begin at multiples of eight
bytes after the encapsulation, and the length of the list directly precedes the first record. So the numbers
of all records have equal distances, and one assignment fills them in.
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from auv_core.cdr import COUNT, STAMP
from auv_core.stamp import stamp_bytes

_NUMBER_BYTES = 8
_TICK = struct.Struct("<q")
_FIRST_ADDRESS_BYTES, _ADDRESS_BYTES = 4, 8


class RowStencil:
    """
    The bytes of a message with a header, a tick and records.

    Parameters
    ----------
    message : bytes
        Serialised message with the addresses of its records; its numbers are overwritten.
    count : int
        Number of records.
    width : int
        Number of float64 per record.

    """

    def __init__(self, message: bytes, count: int, width: int) -> None:
        self._bytes = bytearray(message)
        stride = _ADDRESS_BYTES + _NUMBER_BYTES * width
        records = count * stride - (_ADDRESS_BYTES - _FIRST_ADDRESS_BYTES if count else 0)
        records_at = len(message) - records
        self._tick_at = records_at - COUNT.size - _TICK.size
        self._numbers = np.ndarray(
            (count, width),
            dtype="<f8",
            buffer=self._bytes,
            offset=records_at + (_FIRST_ADDRESS_BYTES if count else 0),
            strides=(stride, _NUMBER_BYTES),
        )

    def filled(self, t_s: float, tick: int, rows: NDArray[np.float64]) -> bytes:
        """Return the message with a stamp (s, to the nanosecond), a tick and (count, width) numbers."""
        self._bytes[STAMP] = stamp_bytes(t_s)
        _TICK.pack_into(self._bytes, self._tick_at, tick)
        self._numbers[:] = rows
        return bytes(self._bytes)
