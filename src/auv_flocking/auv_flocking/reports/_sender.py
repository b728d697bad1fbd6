"""What every report checks before it is sent, and what the small ones say of their sender."""

from __future__ import annotations

import math

from auv_flocking.codec import Field, Levels, RatioField, Reserved
from auv_flocking.heard import BITS, CODES
from auv_flocking.report import Report, ReportError

_ADDRESSES = 256
_HEADING_STEP_RAD = math.pi / 64.0

STATE_FIELDS: tuple[Levels, ...] = (
    Field("heading_rad", -math.pi, math.pi, _HEADING_STEP_RAD, wraps=True),
    RatioField("position_sd_m", 2.0**-8, steps_per_octave=16, bits=8),
    Field("is_bounded", 0, 1, 1),
    Field("is_holding", 0, 1, 1),
    Field("heard_code", 0, CODES - 1, 1),
    Field("heard_mask", 0, 2**BITS - 1, 1),
    Reserved("operator_command", 16),
    Reserved("operator_acknowledgement", 4),
)
"""The sender's heading, what it knows of itself and of others, and room for an operator."""


def check_sender(report: Report, n_shared: int) -> None:
    """
    Check the address of a report and the count of its shared numbers.

    Raises
    ------
    ReportError
        For an address without a vehicle, and another count than the format has.

    """
    if len(report.shared) != n_shared:
        raise ReportError(f"{len(report.shared)} shared numbers; this format has {n_shared}")
    if not 0 < report.address < _ADDRESSES:
        raise ReportError(f"address {report.address} cannot be sent")
