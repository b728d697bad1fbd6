"""
The report that a vehicle broadcasts, and its bytes.

Little-endian, fixed length: version (1), address (1), sequence (4), time tag (8), then fifteen 32-bit
floats: position, velocity, flocking centre, its rate, flock velocity, all NED.  Values are rounded to 32
bits (about 1e-6 m at 10 m).
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass

from auv_core.geometry import Vec3

_VERSION = 1
_LAYOUT = struct.Struct("<BBId15f")
REPORT_BYTES = _LAYOUT.size


class ReportError(ValueError):
    """Bytes that are not a report."""


@dataclass(frozen=True, slots=True)
class Report:
    """
    State of one vehicle at its time tag.

    position, centre: m; velocity, centre_rate, flock_velocity: m/s; all NED.
    """

    address: int
    sequence: int
    time_s: float
    position: Vec3
    velocity: Vec3
    centre: Vec3
    centre_rate: Vec3
    flock_velocity: Vec3


def encode(report: Report) -> bytes:
    """Return the `REPORT_BYTES` bytes of a report."""
    return _LAYOUT.pack(
        _VERSION,
        report.address,
        report.sequence,
        report.time_s,
        *report.position,
        *report.velocity,
        *report.centre,
        *report.centre_rate,
        *report.flock_velocity,
    )


def decode(payload: bytes) -> Report:
    """
    Return the report in `payload`.

    Raises
    ------
    ReportError
        For a wrong length, an unknown version, address 0, or a number that is not finite; never anything
        else.

    """
    if len(payload) != REPORT_BYTES:
        raise ReportError(f"a report has {REPORT_BYTES} bytes, this has {len(payload)}")
    version, address, sequence, time_s, *v = _LAYOUT.unpack(payload)
    if version != _VERSION or address == 0:
        raise ReportError(
            f"version {version}, address {address}; "
            f"this program reads version {_VERSION} and addresses from 1"
        )
    if not all(map(math.isfinite, (time_s, *v))):
        raise ReportError("a number in the report is not finite")
    vectors: list[Vec3] = [(v[i], v[i + 1], v[i + 2]) for i in range(0, 15, 3)]
    return Report(address, sequence, time_s, *vectors)
