"""
The report in floating-point numbers, for runs without rounding errors.

Little-endian, as in `_LAYOUT`: whole numbers (B, H: 1 and 2 bytes) and floating-point numbers (f, d: 32 and
64 bits), then the numbers of the consensus filter (64 bits each). The version is in the four highest bits of
its byte. A stamp of minus infinity means that no flock velocity was received. 32 bits round by about 1e-6 m
at 10 m.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from auv_core.geometry import Box
from auv_flocking.codec import Field
from auv_flocking.heard import CODES
from auv_flocking.report import NEVER, Report, ReportError
from auv_flocking.reports import VERSIONS, Bounds, ReportFormat, version_in, whole_numbers
from auv_flocking.reports._exact_v2 import Reader
from auv_flocking.reports._sender import check_sender

_VERSION = VERSIONS["exact"].written
_FIRST_BYTE = _VERSION << 4
_LARGEST = 1e9
_VECTORS = ("position_{}_m", "velocity_{}_mps", "centre_{}_m", "flock_velocity_{}_mps")
_LAYOUT = (
    ("version", "B"),
    ("address", "B"),
    ("is_bounded", "B"),
    ("is_holding", "B"),
    ("heard_code", "B"),
    ("heard_mask", "H"),
    ("operator_command", "H"),
    ("operator_acknowledgement", "B"),
    ("time_s", "d"),
    *((name.format(axis), "f") for name in _VECTORS for axis in ("north", "east", "down")),
    ("flock_stamp_s", "d"),
    ("flock_turn_rate_radps", "f"),
    ("heading_rad", "f"),
    ("position_sd_m", "f"),
)


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


class _Head(NamedTuple):
    """The whole numbers at the beginning of a report."""

    version_byte: int
    address: int
    is_bounded: int
    is_holding: int
    heard_code: int
    heard_mask: int
    operator_command: int
    operator_acknowledgement: int


class Format(ReportFormat):
    """Encodes and decodes reports."""

    position_resolution_m = 0.0
    velocity_resolution_mps = 0.0
    carries = Bounds(
        Box((-_LARGEST, -_LARGEST, -_LARGEST), (_LARGEST, _LARGEST, _LARGEST)),
        velocity_mps=_LARGEST,
        descent_mps=_LARGEST,
        centre_distance_m=_LARGEST,
    )

    def __init__(self, params: Params, shared: Sequence[Field]) -> None:
        self._n_shared = len(shared)
        layout = (*_LAYOUT, *((field.name, "d") for field in shared))
        self._layout = struct.Struct("<" + "".join(code for _, code in layout))
        self.budget = [(name, 8 * struct.calcsize(code)) for name, code in layout]
        self._older = Reader(shared)
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
            For NaN, None, an invalid address, and a wrong number of shared numbers.

        """
        check_sender(report, self._n_shared)
        time_s = self._bounded(report.time_s)
        stamp_s = report.flock_stamp_s
        if stamp_s != NEVER:
            stamp_s = self._bounded(stamp_s)
        if stamp_s > time_s:
            self._saturated += 1
            stamp_s = time_s
        vectors = (*report.position, *report.velocity, *report.centre, *report.flock_velocity)
        return self._layout.pack(
            _FIRST_BYTE,
            report.address,
            *whole_numbers(report),
            0,
            0,
            time_s,
            *map(self._bounded, vectors),
            stamp_s,
            self._bounded(report.flock_turn_rate_radps),
            self._bounded(report.heading_rad),
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
            For a wrong length, a version that is not read, address 0, flags and reserved bits without a
            meaning, a number that is not finite or beyond 1e9, a stamp later than the time tag, a negative
            standard deviation; no other exception is raised.

        """
        is_newest = version_in(payload, "exact") == _VERSION
        report = self._newest(payload) if is_newest else self._older.decode(payload)
        if report.address == 0:
            raise ReportError("address 0 is no vehicle's")
        vectors = (*report.position, *report.velocity, *report.centre, *report.flock_velocity)
        turning = (report.flock_turn_rate_radps, report.heading_rad) if is_newest else ()
        numbers = (report.time_s, *vectors, *turning, report.position_sd_m, *report.shared)
        if not all(-_LARGEST <= number <= _LARGEST for number in numbers):
            raise ReportError("a number in the report is not finite, or beyond 1e9")
        stamp_s = report.flock_stamp_s
        is_stamp = stamp_s == NEVER or stamp_s >= -_LARGEST
        if not stamp_s <= report.time_s or not is_stamp or report.position_sd_m < 0.0:
            raise ReportError("the stamp or the standard deviation of the report cannot be")
        return report

    def _newest(self, payload: bytes) -> Report:
        if len(payload) != self.payload_bytes:
            raise ReportError(f"a report has {self.payload_bytes} bytes, this has {len(payload)}")
        numbers = self._layout.unpack(payload)
        head, time_s, v = _Head(*numbers[:8]), float(numbers[8]), numbers[9:]
        is_reserved = head.operator_command or head.operator_acknowledgement
        is_known = max(head.is_bounded, head.is_holding) <= 1 and head.heard_code < CODES
        if head.version_byte != _FIRST_BYTE or is_reserved or not is_known:
            raise ReportError("bits without a meaning are not zero")
        p, u, c, w = [(v[i], v[i + 1], v[i + 2]) for i in range(0, 12, 3)]
        stamp_s, turn_radps, heading_rad, sd_m, *shared = v[12:]
        return Report(
            head.address,
            time_s,
            p,
            u,
            c,
            w,
            stamp_s,
            turn_radps,
            heading_rad,
            sd_m,
            bool(head.is_bounded),
            bool(head.is_holding),
            head.heard_code,
            head.heard_mask,
            tuple(shared),
        )
