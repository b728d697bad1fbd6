"""Wrapped time tags, and stamps as ages at the time tag, in steps of 0.01 s: the times of `compact`."""

from __future__ import annotations

from auv_flocking.codec import Field
from auv_flocking.report import NEVER, Report

STEP_S = 0.01
_AGE_LEVELS = 2**14
_NEVER_S = (_AGE_LEVELS - 1) * STEP_S
OLDEST_S = (_AGE_LEVELS - 2) * STEP_S
AGE = Field("flock_velocity_age_s", 0.0, _NEVER_S, STEP_S)


def tag_field(levels: int) -> Field:
    """Return the field of a time tag that wraps after so many steps."""
    return Field("time_s", 0.0, levels * STEP_S, STEP_S, wraps=True)


def age_of_stamp_s(report: Report) -> float:
    """Return the age of the flock velocity at the rounded time tag (s); all ones: none was received."""
    if report.flock_stamp_s == NEVER:
        return _NEVER_S
    return round(report.time_s / STEP_S) * STEP_S - report.flock_stamp_s


def times_s(tag_s: float, age_s: float, levels: int, now_s: float) -> tuple[float, float]:
    """Return the possible time tag nearest to `now_s`, and the stamp (s)."""
    step, age = _tagged(tag_s, levels, now_s), round(age_s / STEP_S)
    return step * STEP_S, NEVER if age == _AGE_LEVELS - 1 else (step - age) * STEP_S


def tagged_s(tag_s: float, levels: int, now_s: float) -> float:
    """Return the possible time tag nearest to `now_s` (s)."""
    return _tagged(tag_s, levels, now_s) * STEP_S


def _tagged(tag_s: float, levels: int, now_s: float) -> int:
    step = round(tag_s / STEP_S)
    return step + levels * round((now_s / STEP_S - step) / levels)
