"""
The report in 32 bytes, the frame of a WHOI micromodem: bounded fields without gaps.

`base_fields` is the layout; the numbers of the consensus filter are appended and make the payload longer.
The flocking centre is sent relative to the rounded position, so that its error is half a resolution and not
the sum of two. The time tag wraps (after 655.36 s) and is decoded as the time nearest to the receiver's. The
stamp of the flock velocity is sent as its age at the time tag, with the time tag's resolution: if control
periods are multiples of it, vehicles pass stamps on without accumulating errors.

The deviation of the position has steps of a constant ratio, 4.4 %. A receiver takes a fall of more than 5 %
for a position fix: one step is less than that, so rounding does not feign a fix, and a deviation above zero
never becomes zero, which would mean an exact navigation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from auv_core.geometry import Box, Vec3
from auv_core.params import param
from auv_flocking.codec import Field, Layout, Levels, steps_around_zero
from auv_flocking.report import Report, ReportError
from auv_flocking.reports import VERSIONS, Bounds, ReportFormat, version_in, whole_numbers
from auv_flocking.reports._compact_v3 import Reader
from auv_flocking.reports._sender import STATE_FIELDS, check_sender
from auv_flocking.reports._tags import AGE, OLDEST_S, age_of_stamp_s, tag_field, times_s

_VERSION = VERSIONS["compact"].written
_TIME_LEVELS = 2**16
_TURN_STEP_RADPS = 0.001
_UNUSED = (0.0, 0.0)


@dataclass(frozen=True)
class Params:
    """
    Resolutions; the number of bits is fixed, so the bounds scale with them. All vehicles of a flock use the
    same.
    """

    position_resolution_m: float = param(
        "step of the position (m); bounds are 262144 steps north and east, 512 up and 32255 down from the "
        "surface; the centre has twice the step, four times downwards, and is within 4092 steps",
        default=0.02,
        minimum=0.001,
        maximum=1.0,
    )
    velocity_resolution_mps: float = param(
        "step of the own velocity (m/s), bounds 1022 steps, 510 downwards; the flock velocity has twice the "
        "step",
        default=0.0025,
        minimum=0.0001,
        maximum=0.1,
    )


def base_fields(params: Params) -> tuple[Levels, ...]:
    """Return the fields that every report has, in their order."""
    step_m, step_mps = params.position_resolution_m, params.velocity_resolution_mps
    return (
        Field("version", 0, 15, 1),
        Field("address", 0, 255, 1),
        tag_field(_TIME_LEVELS),
        *_position_fields(step_m),
        *_velocity_fields("velocity", step_mps, 2**10),
        *_centre_fields(step_m),
        *_velocity_fields("flock_velocity", 2.0 * step_mps, 2**9),
        AGE,
        steps_around_zero("flock_turn_rate_radps", _TURN_STEP_RADPS, 2**7),
        *STATE_FIELDS,
    )


def _position_fields(step_m: float) -> tuple[Field, Field, Field]:
    return (
        steps_around_zero("position_north_m", step_m, 2**18),
        steps_around_zero("position_east_m", step_m, 2**18),
        Field("position_down_m", -(2**9) * step_m, (2**15 - 2**9 - 1) * step_m, step_m),
    )


def _centre_fields(step_m: float) -> tuple[Field, Field, Field]:
    return (
        steps_around_zero("centre_minus_position_north_m", 2.0 * step_m, 2**11),
        steps_around_zero("centre_minus_position_east_m", 2.0 * step_m, 2**11),
        steps_around_zero("centre_minus_position_down_m", 4.0 * step_m, 2**10),
    )


def _velocity_fields(name: str, step_mps: float, half: int) -> tuple[Field, Field, Field]:
    """Return fields of so many steps to each side; half as many vertically."""
    return (
        steps_around_zero(f"{name}_north_mps", step_mps, half),
        steps_around_zero(f"{name}_east_mps", step_mps, half),
        steps_around_zero(f"{name}_down_mps", step_mps, half // 2),
    )


class Format(ReportFormat):
    """Encodes and decodes reports."""

    def __init__(self, params: Params, shared: Sequence[Field]) -> None:
        step_m, step_mps = params.position_resolution_m, params.velocity_resolution_mps
        fields = base_fields(params)
        self._layout = Layout((*fields, *shared))
        self._n_base = len(fields)
        self._position = _position_fields(step_m)
        self._older = Reader(step_m, step_mps, shared)
        self._too_old = 0
        north, east, down = self._position
        flock_north, _, flock_down = _velocity_fields("flock_velocity", 2.0 * step_mps, 2**9)
        self.carries = Bounds(
            Box(
                (north.minimum, east.minimum, down.minimum),
                (north.maximum, east.maximum, down.maximum),
            ),
            velocity_mps=flock_north.maximum,
            descent_mps=flock_down.maximum,
            centre_distance_m=min(field.maximum for field in _centre_fields(step_m)),
        )
        self.payload_bytes = self._layout.payload_bytes
        self.budget = [(field.name, field.bits) for field in self._layout.fields]
        self.position_resolution_m = step_m
        self.velocity_resolution_mps = step_mps

    @property
    def fields(self) -> tuple[Levels, ...]:
        """The layout, in the order of its bits."""
        return self._layout.fields

    @property
    def saturated(self) -> int:
        """Number of values that were out of bounds so far."""
        return self._layout.saturated + self._too_old

    def encode(self, report: Report) -> bytes:
        """
        Return the payload of a report; values out of bounds saturate.

        Raises
        ------
        ReportError
            For NaN, None, an invalid address, and a wrong number of shared numbers.

        """
        check_sender(report, len(self._layout.fields) - self._n_base)
        if not math.isfinite(report.time_s):
            raise ReportError(f"time {report.time_s} cannot be sent")
        north, east, down = map(Field.rounded, self._position, report.position)
        x, y, z = report.centre
        return self._layout.pack(
            (
                _VERSION,
                report.address,
                report.time_s,
                *report.position,
                *report.velocity,
                x - north,
                y - east,
                z - down,
                *report.flock_velocity,
                self._age_s(report),
                report.flock_turn_rate_radps,
                report.heading_rad,
                report.position_sd_m,
                *whole_numbers(report),
                *_UNUSED,
                *report.shared,
            )
        )

    def _age_s(self, report: Report) -> float:
        """Return the age of the flock velocity (s), and count one that is too old."""
        age_s = age_of_stamp_s(report)
        if age_s > OLDEST_S and math.isfinite(report.flock_stamp_s):
            self._too_old += 1
            return OLDEST_S
        return age_s

    def decode(self, payload: bytes, now_s: float) -> Report:
        """
        Return the report in `payload`; its time tag is the possible time nearest to `now_s` (finite).

        Raises
        ------
        ReportError
            For a wrong length, a version that is not read, address 0, reserved bits and padding that are not
            zero, and invalid shared numbers; no other exception is raised.

        """
        if version_in(payload, "compact") == _VERSION:
            report = self._newest(payload, now_s)
        else:
            report = self._older.decode(payload, now_s)
        if report.address == 0:
            raise ReportError("address 0 is no vehicle's")
        return report

    def _newest(self, payload: bytes, now_s: float) -> Report:
        v = self._layout.unpack(payload)
        time_s, stamp_s = times_s(v[2], v[15], _TIME_LEVELS, now_s)
        position: Vec3 = (v[3], v[4], v[5])
        return Report(
            int(v[1]),
            time_s,
            position,
            (v[6], v[7], v[8]),
            (v[3] + v[9], v[4] + v[10], v[5] + v[11]),
            (v[12], v[13], v[14]),
            stamp_s,
            v[16],
            v[17],
            v[18],
            bool(v[19]),
            bool(v[20]),
            int(v[21]),
            int(v[22]),
            tuple(v[self._n_base :]),
        )
