"""
Version 3 of `compact`, which older recordings contain; nothing is sent in it.

It has a sequence number and the rate of the centre in every report, a linear step of the deviation, and
neither heading, turn rate of the flock velocity, `is_bounded`, `is_holding` nor what the sender has heard.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from auv_flocking.codec import Field, Layout, steps_around_zero
from auv_flocking.report import Report
from auv_flocking.reports._tags import AGE, tag_field, times_s

_TIME_LEVELS = 2**20
_AXES = ("north", "east", "down")


class Reader:
    """
    Decodes reports of version 3.

    Parameters
    ----------
    step_m, step_mps : float
        Resolutions of position and velocity (m, m/s).
    shared : sequence of Field
        The fields that the consensus filter adds today. The rate of the centre is not added in this version,
        since every report has it.

    """

    def __init__(self, step_m: float, step_mps: float, shared: Sequence[Field]) -> None:
        base = _base_fields(step_m, step_mps)
        inside = {field.name for field in base}
        self._layout = Layout((*base, *(field for field in shared if field.name not in inside)))
        self._names = [field.name for field in self._layout.fields]
        self._shared = [field.name for field in shared]

    def decode(self, payload: bytes, now_s: float) -> Report:
        """Return the report; raise `ReportError` for bytes that are none, except for an address 0."""
        v = dict(zip(self._names, self._layout.unpack(payload), strict=True))
        north, east, down = (v[f"position_{axis}_m"] for axis in _AXES)
        x, y, z = (v[f"centre_minus_position_{axis}_m"] for axis in _AXES)
        u, w = ([v[f"{name}_{axis}_mps"] for axis in _AXES] for name in ("velocity", "flock_velocity"))
        time_s, stamp_s = times_s(v["time_s"], v[AGE.name], _TIME_LEVELS, now_s)
        return Report(
            int(v["address"]),
            time_s,
            (north, east, down),
            (u[0], u[1], u[2]),
            (north + x, east + y, down + z),
            (w[0], w[1], w[2]),
            stamp_s,
            flock_turn_rate_radps=math.nan,
            heading_rad=math.nan,
            position_sd_m=v["position_sd_m"],
            is_bounded=None,
            is_holding=None,
            heard_code=None,
            heard_mask=None,
            shared=tuple([v[name] for name in self._shared]),
        )


def _base_fields(step_m: float, step_mps: float) -> tuple[Field, ...]:
    return (
        Field("version", 0, 15, 1),
        Field("address", 0, 255, 1),
        Field("sequence", 0, 4096, 1, wraps=True),
        tag_field(_TIME_LEVELS),
        steps_around_zero("position_north_m", step_m, 2**18),
        steps_around_zero("position_east_m", step_m, 2**18),
        Field("position_down_m", -(2**13) * step_m, (2**16 - 2**13 - 1) * step_m, step_m),
        *(steps_around_zero(f"velocity_{axis}_mps", step_mps, 2**10) for axis in _AXES),
        *(steps_around_zero(f"centre_minus_position_{axis}_m", step_m, 2**12) for axis in _AXES),
        *(steps_around_zero(f"centre_rate_{axis}_mps", 2.0 * step_mps, 2**9) for axis in _AXES),
        *(steps_around_zero(f"flock_velocity_{axis}_mps", 2.0 * step_mps, 2**9) for axis in _AXES),
        AGE,
        Field("position_sd_m", 0.0, 511 * 0.04, 0.04),
    )
