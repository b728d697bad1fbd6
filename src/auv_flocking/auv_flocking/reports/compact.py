"""
The report in 32 bytes, the frame of a WHOI micromodem: bounded fields without gaps.

`base_fields` is the layout; the numbers of the consensus filter are appended and make the payload longer.
The flocking centre is sent relative to the rounded position, so that its error is half a resolution and not a
whole one. The time tag wraps (after 2.9 h) and is decoded as the time nearest to the receiver's. The stamp of
the flock velocity is sent as its age at the time tag, with the time tag's resolution: if control periods are
multiples of it, vehicles pass stamps on without accumulating errors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from auv_core.geometry import Box, Vec3
from auv_core.params import param
from auv_flocking.codec import Field, Layout
from auv_flocking.report import NEVER, Report, ReportError
from auv_flocking.reports import Bounds, ReportFormat

VERSION = 3
_TIME_RESOLUTION_S = 0.01
_TIME_LEVELS = 2**20
_AGE_LEVELS = 2**14
_OLDEST_S = (_AGE_LEVELS - 2) * _TIME_RESOLUTION_S
_NEVER_S = (_AGE_LEVELS - 1) * _TIME_RESOLUTION_S
_AXES = ("north", "east", "down")


@dataclass(frozen=True)
class Params:
    """
    Resolutions; the number of bits is fixed, so the bounds scale with them. All vehicles of a flock use the
    same.
    """

    position_resolution_m: float = param(
        "step of position and centre (m); bounds are 262144 steps north and east, and the centre within 4096 "
        "steps of the vehicle",
        default=0.02,
        minimum=0.001,
        maximum=1.0,
    )
    velocity_resolution_mps: float = param(
        "step of the own velocity (m/s), bounds 1024 steps; the other velocities have twice the step",
        default=0.0025,
        minimum=0.0001,
        maximum=0.1,
    )


def base_fields(params: Params) -> tuple[Field, ...]:
    """Return the fields that every report has, in their order."""
    step_m, step_mps = params.position_resolution_m, params.velocity_resolution_mps
    return (
        Field("version", 0, 15, 1),
        Field("address", 0, 255, 1),
        Field("sequence", 0, 4096, 1, wraps=True),
        Field("time_s", 0.0, _TIME_LEVELS * _TIME_RESOLUTION_S, _TIME_RESOLUTION_S, wraps=True),
        _steps("position_north_m", step_m, 2**18),
        _steps("position_east_m", step_m, 2**18),
        Field("position_down_m", -(2**13) * step_m, (2**16 - 2**13 - 1) * step_m, step_m),
        *(_steps(f"velocity_{axis}_mps", step_mps, 2**10) for axis in _AXES),
        *(_steps(f"centre_minus_position_{axis}_m", step_m, 2**12) for axis in _AXES),
        *(_steps(f"centre_rate_{axis}_mps", 2.0 * step_mps, 2**9) for axis in _AXES),
        *(_steps(f"flock_velocity_{axis}_mps", 2.0 * step_mps, 2**9) for axis in _AXES),
        Field("flock_velocity_age_s", 0.0, _NEVER_S, _TIME_RESOLUTION_S),
        Field("position_sd_m", 0.0, 511 * 0.04, 0.04),
    )


def _steps(name: str, step: float, half: int) -> Field:
    """Return a field of -half .. half - 1 steps."""
    return Field(name, -half * step, (half - 1) * step, step)


def _corner(fields: Sequence[Field], side: str) -> Vec3:
    """Return the smallest or the largest values of three fields."""
    x, y, z = (getattr(item, side) for item in fields)
    return (x, y, z)


class Format(ReportFormat):
    """Encodes and decodes reports."""

    def __init__(self, params: Params, shared: Sequence[Field]) -> None:
        fields = base_fields(params)
        self._layout = Layout((*fields, *shared))
        self._n_base = len(fields)
        self._time = fields[3]
        self._position = fields[4:7]
        self._too_old = 0
        self.carries = Bounds(
            Box(_corner(fields[4:7], "minimum"), _corner(fields[4:7], "maximum")),
            velocity_mps=min(item.maximum for item in (*fields[7:10], *fields[13:19])),
            centre_distance_m=min(item.maximum for item in fields[10:13]),
        )
        self.payload_bytes = self._layout.payload_bytes
        self.position_resolution_m = params.position_resolution_m
        self.velocity_resolution_mps = params.velocity_resolution_mps

    @property
    def fields(self) -> tuple[Field, ...]:
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
            For NaN, for an invalid address, and for a wrong number of shared numbers.

        """
        if len(report.shared) != len(self._layout.fields) - self._n_base:
            raise ReportError(
                f"{len(report.shared)} shared numbers; this format has "
                f"{len(self._layout.fields) - self._n_base}"
            )
        if not 0 < report.address < 256:
            raise ReportError(f"address {report.address} cannot be sent")
        if not math.isfinite(report.time_s):
            raise ReportError(f"time {report.time_s} cannot be sent")
        north, east, down = map(Field.rounded, self._position, report.position)
        x, y, z = report.centre
        return self._layout.pack(
            (
                VERSION,
                report.address,
                report.sequence,
                report.time_s,
                *report.position,
                *report.velocity,
                x - north,
                y - east,
                z - down,
                *report.centre_rate,
                *report.flock_velocity,
                self._age_s(report),
                report.position_sd_m,
                *report.shared,
            )
        )

    def _age_s(self, report: Report) -> float:
        """Return the rounded age of the flock velocity at the time tag (s)."""
        if report.flock_stamp_s == NEVER:
            return _NEVER_S
        tag_s = round(report.time_s / _TIME_RESOLUTION_S) * _TIME_RESOLUTION_S
        age_s = tag_s - report.flock_stamp_s
        if age_s > _OLDEST_S:
            self._too_old += 1
            return _OLDEST_S
        return age_s

    def decode(self, payload: bytes, now_s: float) -> Report:
        """
        Return the report in `payload`; its time tag is the possible time nearest to `now_s` (finite).

        Raises
        ------
        ReportError
            For a wrong length, another version, address 0, padding that is not zero, and invalid shared
            numbers; no other exception is raised.

        """
        if payload and payload[0] >> 4 != VERSION:
            raise ReportError(f"version {payload[0] >> 4}; this format reads version {VERSION}")
        v = self._layout.unpack(payload)
        address = int(v[1])
        if address == 0:
            raise ReportError("address 0 is no vehicle's")
        step = round(v[3] / _TIME_RESOLUTION_S)
        turns = round((now_s / _TIME_RESOLUTION_S - step) / _TIME_LEVELS)
        step += turns * _TIME_LEVELS
        age = round(v[19] / _TIME_RESOLUTION_S)
        stamp_s = NEVER if age == _AGE_LEVELS - 1 else (step - age) * _TIME_RESOLUTION_S
        position: Vec3 = (v[4], v[5], v[6])
        return Report(
            address,
            int(v[2]),
            step * _TIME_RESOLUTION_S,
            position,
            (v[7], v[8], v[9]),
            (v[4] + v[10], v[5] + v[11], v[6] + v[12]),
            (v[13], v[14], v[15]),
            (v[16], v[17], v[18]),
            stamp_s,
            v[20],
            tuple(v[21:]),
        )
