"""
The report that a vehicle broadcasts: the record itself.  Its bytes are made by a format of the folder
``reports``.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass

from auv_core.geometry import Vec3

_VERSION = 1
_LAYOUT = struct.Struct("<BBId15f")
REPORT_BYTES = _LAYOUT.size

NEVER = -math.inf


class ReportError(ValueError):
    """Bytes that are not a report, or numbers that cannot be sent as one."""


@dataclass(frozen=True, slots=True)
class Report:
    """
    State of one vehicle at its time tag.

    position, centre: m; velocity, centre_rate, flock_velocity: m/s; all NED.  `flock_stamp_s`: when a leader
    made this flock velocity, on its way from vehicle to vehicle never later than a time tag; `NEVER` where
    none was heard.  `position_sd_m`: what the sender's navigation says of itself, per horizontal axis (1
    sigma).  `shared`: the numbers that the sender's consensus filter adds.
    """

    address: int
    sequence: int
    time_s: float
    position: Vec3
    velocity: Vec3
    centre: Vec3
    centre_rate: Vec3
    flock_velocity: Vec3
    flock_stamp_s: float = NEVER
    position_sd_m: float = 0.0
    shared: tuple[float, ...] = ()


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
    p, u, c, r, w = [(v[i], v[i + 1], v[i + 2]) for i in range(0, 15, 3)]
    return Report(address, sequence, time_s, p, u, c, r, w)
