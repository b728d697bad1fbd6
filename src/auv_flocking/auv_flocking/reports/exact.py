"""
The report in floating-point numbers, for runs without rounding errors.

Little-endian: version (1 byte), address (1), sequence (4), time tag (8), then fifteen 32-bit floats:
position, velocity, flocking centre, its rate, flock velocity, all NED; the stamp of the flock velocity (64
bits; minus infinity: never heard), the position's standard deviation (32 bits), and the numbers of the
consensus filter (64 bits each). 32 bits round by about 1e-6 m at 10 m.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass

from auv_core.geometry import Box
from auv_flocking.codec import Field
from auv_flocking.report import NEVER, Report, ReportError
from auv_flocking.reports import Bounds, ReportFormat

VERSION = 2
_LARGEST = 1e9
_ADDRESSES = 256
_SEQUENCES = 2**32


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


class Format(ReportFormat):
    """Encodes and decodes reports."""

    position_resolution_m = 0.0
    velocity_resolution_mps = 0.0
    carries = Bounds(
        Box((-_LARGEST, -_LARGEST, -_LARGEST), (_LARGEST, _LARGEST, _LARGEST)),
        velocity_mps=_LARGEST,
        centre_distance_m=_LARGEST,
    )

    def __init__(self, params: Params, shared: Sequence[Field]) -> None:
        self._n_shared = len(shared)
        self._layout = struct.Struct(f"<BBId15fdf{self._n_shared}d")
        self.payload_bytes = self._layout.size
        self._saturated = 0

    @property
    def saturated(self) -> int:
        """How many values had to be bounded so far."""
        return self._saturated

    def encode(self, report: Report) -> bytes:
        """
        Return the payload of a report.

        Numbers beyond 1e9 saturate; so does a stamp later than the time tag.

        Raises
        ------
        ReportError
            For NaN, for an invalid address, and for a wrong number of shared numbers.

        """
        if len(report.shared) != self._n_shared:
            raise ReportError(f"{len(report.shared)} shared numbers; this format has {self._n_shared}")
        if not 0 < report.address < _ADDRESSES:
            raise ReportError(f"address {report.address} cannot be sent")
        time_s = self._bounded(report.time_s)
        stamp_s = report.flock_stamp_s
        if stamp_s != NEVER:
            stamp_s = self._bounded(stamp_s)
        if stamp_s > time_s:
            self._saturated += 1
            stamp_s = time_s
        vectors = (
            *report.position,
            *report.velocity,
            *report.centre,
            *report.centre_rate,
            *report.flock_velocity,
        )
        return self._layout.pack(
            VERSION,
            report.address,
            report.sequence % _SEQUENCES,
            time_s,
            *map(self._bounded, vectors),
            stamp_s,
            max(0.0, self._bounded(report.position_sd_m)),
            *map(self._bounded, report.shared),
        )

    def _bounded(self, value: float) -> float:
        if -_LARGEST <= value <= _LARGEST:
            return value
        if math.isnan(value):
            raise ReportError("a number that is not a number cannot be sent")
        self._saturated += 1
        return math.copysign(_LARGEST, value)

    def decode(self, payload: bytes, now_s: float) -> Report:
        """
        Return the report in `payload`; `now_s` is not needed, since the time tag does not wrap.

        Raises
        ------
        ReportError
            For a wrong length, another version, address 0, a number that is not finite or beyond 1e9, a
            stamp later than the time tag, a negative standard deviation; no other exception is raised.

        """
        if len(payload) != self.payload_bytes:
            raise ReportError(f"a report has {self.payload_bytes} bytes, this has {len(payload)}")
        version, address, sequence, time_s, *v = self._layout.unpack(payload)
        if version != VERSION or address == 0:
            raise ReportError(
                f"version {version}, address {address}; "
                f"this format reads version {VERSION} and addresses from 1"
            )
        stamp_s, sd_m, shared = v[15], v[16], tuple(v[17:])
        if not all(-_LARGEST <= number <= _LARGEST for number in (time_s, *v[:15], sd_m, *shared)):
            raise ReportError("a number in the report is not finite, or beyond 1e9")
        if not stamp_s <= time_s or not (stamp_s == NEVER or stamp_s >= -_LARGEST) or sd_m < 0.0:
            raise ReportError("the stamp or the standard deviation of the report cannot be")
        p, u, c, r, w = [(v[i], v[i + 1], v[i + 2]) for i in range(0, 15, 3)]
        return Report(address, sequence, time_s, p, u, c, r, w, stamp_s, sd_m, shared)
