"""
The age of inputs, and whether an input is too old, or too far in the future, to be used.

An age is the time of use minus the time of the input, both in scenario time.  In lock-step and in one process
it is 0; in real time an input may be late, stop coming, or come from another clock.
"""

from __future__ import annotations

from typing import Generic, TypeVar

T = TypeVar("T")

_ROUNDING_S = 1e-9
_LEAST_PERIODS = 2.0


def age_limit_s(max_age_s: float, period_s: float) -> float:
    """Return the largest age of an input (s): the given limit, but at least two control periods."""
    return max(max_age_s, _LEAST_PERIODS * period_s) + _ROUNDING_S


def why_not_now(age_s: float, limit_s: float) -> str:
    """Return why an input of this age (s) cannot be used, or an empty text if it can."""
    if age_s > limit_s:
        return f"{age_s:.1f} s old, allowed: {limit_s:.3g} s"
    if age_s < -limit_s:
        return f"{-age_s:.1f} s in the future, allowed: {limit_s:.3g} s"
    return ""


class Newest(Generic[T]):
    """
    The newest input of one kind in real time, with its tick.

    The newest input is the one that arrived last. An input from the future is dropped, since it would block
    all others until then. An old input is replaced by a fresh one, so that a restarted source counts once it
    has caught up with the clock.

    Attributes
    ----------
    value
        The newest input, or None before the first.
    tick : int
        Its tick; before the first input, that of the start.
    dropped : int
        Number of inputs that were not used.
    dropped_words : str
        Why the last of them was not used.

    """

    def __init__(self, limit_s: float, period_s: float) -> None:
        self.limit_s = limit_s
        self._period_s = period_s
        self.value: T | None = None
        self.tick = 0
        self.dropped = 0
        self.dropped_words = ""

    def start(self, tick: int) -> None:
        """Count the age from this tick on, if there is no input yet."""
        if self.value is None:
            self.tick = tick

    def hear(self, value: T, tick: int, now_tick: int) -> bool:
        """Take an input of a tick; return whether it is now the newest one."""
        words = self.why_stale(now_tick, tick)
        if words and (tick > now_tick or (self.value is not None and not self.why_stale(now_tick))):
            self.drop(tick, now_tick, words)
            return False
        self.value, self.tick = value, tick
        return True

    def drop(self, tick: int, now_tick: int, words: str) -> None:
        """Count an input of a tick that is not used, with the reason."""
        self.dropped += 1
        self.dropped_words = f"tick {tick} at tick {now_tick}: {words}"

    def why_stale(self, now_tick: int, tick: int | None = None) -> str:
        """Return why the newest input, or one of `tick`, cannot be used now, or an empty text."""
        return why_not_now((now_tick - (self.tick if tick is None else tick)) * self._period_s, self.limit_s)
