"""
The report of a vehicle in a lane: position and velocity, but no flocking centre and no flock velocity.

With the fields of a lane, which the lane's task adds, it has 32 bytes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from auv_core.geometry import Box, Vec3
from auv_core.params import param
from auv_flocking.codec import Field, Layout, Levels, Reserved, steps_around_zero
from auv_flocking.report import NEVER, Report, ReportError
from auv_flocking.reports import VERSIONS, Bounds, ReportFormat, version_in, whole_numbers
from auv_flocking.reports._sender import STATE_FIELDS, check_sender
from auv_flocking.reports._tags import tag_field, tagged_s

_VERSION = VERSIONS["lane"].written
_TIME_LEVELS = 2**20
_UNUSED = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Params:
    """Resolutions; the number of bits is fixed, so the bounds scale with them."""

    position_resolution_m: float = param(
        "step of the position (m); bounds are 262144 steps north and east, 512 up and 65023 down",
        default=0.05,
        minimum=0.001,
        maximum=1.0,
    )
    velocity_resolution_mps: float = param(
        "step of the velocity (m/s), bounds 1024 steps", default=0.005, minimum=0.0001, maximum=0.1
    )


def base_fields(params: Params) -> tuple[Levels, ...]:
    """Return the fields that every report has, in their order."""
    step_m, step_mps = params.position_resolution_m, params.velocity_resolution_mps
    return (
        Field("version", 0, 15, 1),
        Field("address", 0, 255, 1),
        tag_field(_TIME_LEVELS),
        steps_around_zero("position_north_m", step_m, 2**18),
        steps_around_zero("position_east_m", step_m, 2**18),
        Field("position_down_m", -(2**9) * step_m, (2**16 - 2**9 - 1) * step_m, step_m),
        steps_around_zero("velocity_north_mps", step_mps, 2**10),
        steps_around_zero("velocity_east_mps", step_mps, 2**10),
        steps_around_zero("velocity_down_mps", step_mps, 2**10),
        *STATE_FIELDS,
        Reserved("reserve", 12),
    )


class Format(ReportFormat):
    """
    Encodes and decodes reports.

    The centre of a decoded one is its position. Its flock velocity is its own velocity, so that a filter in
    which velocities relax to that of the flock goes on with it.
    """

    def __init__(self, params: Params, shared: Sequence[Field]) -> None:
        fields = base_fields(params)
        self._layout = Layout((*fields, *shared))
        self._n_base = len(fields)
        down_m, north_mps = fields[5], fields[6]
        edge_m = 2**18 * params.position_resolution_m
        self.carries = Bounds(
            Box(
                (-edge_m, -edge_m, down_m.value(0)),
                (
                    edge_m - params.position_resolution_m,
                    edge_m - params.position_resolution_m,
                    down_m.value(down_m.levels - 1),
                ),
            ),
            velocity_mps=north_mps.value(north_mps.levels - 1),
            descent_mps=north_mps.value(north_mps.levels - 1),
            centre_distance_m=math.inf,
        )
        self.payload_bytes = self._layout.payload_bytes
        self.budget = [(field.name, field.bits) for field in self._layout.fields]
        self.position_resolution_m = params.position_resolution_m
        self.velocity_resolution_mps = params.velocity_resolution_mps

    @property
    def fields(self) -> tuple[Levels, ...]:
        """The layout, in the order of its bits."""
        return self._layout.fields

    @property
    def saturated(self) -> int:
        """Number of values that were out of bounds so far."""
        return self._layout.saturated

    def encode(self, report: Report) -> bytes:
        """
        Return the payload of a report; values out of bounds saturate.

        Raises
        ------
        ReportError
            For NaN, also in what is not sent, an invalid address, and a wrong number of shared numbers.

        """
        check_sender(report, len(self._layout.fields) - self._n_base)
        if not math.isfinite(report.time_s):
            raise ReportError(f"time {report.time_s} cannot be sent")
        if math.isnan(sum(report.centre) + report.flock_stamp_s + report.flock_turn_rate_radps):
            raise ReportError("a number that is not a number cannot be sent")
        return self._layout.pack(
            (
                _VERSION,
                report.address,
                report.time_s,
                *report.position,
                *report.velocity,
                report.heading_rad,
                report.position_sd_m,
                *whole_numbers(report),
                *_UNUSED,
                *report.shared,
            )
        )

    def decode(self, payload: bytes, now_s: float) -> Report:
        """
        Return the report in `payload`; its time tag is the possible time nearest to `now_s` (finite).

        Raises
        ------
        ReportError
            For a wrong length, a version that is not read, address 0, reserved bits and padding that are not
            zero, and invalid shared numbers; no other exception is raised.

        """
        version_in(payload, "lane")
        v = self._layout.unpack(payload)
        if v[1] == 0.0:
            raise ReportError("address 0 is no vehicle's")
        position: Vec3 = (v[3], v[4], v[5])
        velocity: Vec3 = (v[6], v[7], v[8])
        return Report(
            int(v[1]),
            tagged_s(v[2], _TIME_LEVELS, now_s),
            position,
            velocity,
            position,
            velocity,
            NEVER,
            0.0,
            v[9],
            v[10],
            bool(v[11]),
            bool(v[12]),
            int(v[13]),
            int(v[14]),
            tuple(v[self._n_base :]),
        )
