"""
How old an input is, and whether that is too old, or too far ahead of the clock, to be used.

An age is the time of use minus the time of the input, both in scenario time.  In lock-step and in one process
it is 0; in real time an input may be late, stop, or come from another clock.
"""

from __future__ import annotations

_ROUNDING_S = 1e-9
_LEAST_PERIODS = 2.0


def age_limit_s(max_age_s: float, period_s: float) -> float:
    """Return the largest age of an input (s): what is asked for, and at least two control periods."""
    return max(max_age_s, _LEAST_PERIODS * period_s) + _ROUNDING_S


def why_not_now(age_s: float, limit_s: float) -> str:
    """Return why an input of this age (s) is of no use, or nothing where it is of use."""
    if age_s > limit_s:
        return f"{age_s:.1f} s old, allowed: {limit_s:.3g} s"
    if age_s < -limit_s:
        return f"{-age_s:.1f} s in the future, allowed: {limit_s:.3g} s"
    return ""
