"""The time line of a bag: the run's own time, which no stamp of a message can stretch."""

from __future__ import annotations

_SLACK_NS = 10_000_000_000
"""How far ahead of the newest own time a stamp may be; clocks of several machines differ a little."""
_LEAD_TICKS = 250
"""How many ticks lock-step may be ahead of what its recorder has taken."""
_LARGEST_STEP_NS = 3600 * 1_000_000_000


class TimeLine:
    """
    The time of a run, as its clock node tells it.

    Attributes
    ----------
    begin_ns : int, optional
        Stamp of tick 0 (ns), once known.
    now_ns : int
        Newest own time (ns).

    """

    def __init__(self) -> None:
        self.begin_ns: int | None = None
        self.now_ns = 0
        self._tick_ns = 0

    def tell_tick(self, stamp_ns: int) -> None:
        """Take the next tick of lock-step."""
        if self.begin_ns is not None:
            self._tick_ns = max(self._tick_ns, min(stamp_ns - self.now_ns, _LARGEST_STEP_NS))
        self.tell(stamp_ns)

    def tell(self, stamp_ns: int) -> None:
        """Take a time of the clock node; one that is far from the last is not the run's."""
        if self.begin_ns is None:
            self.begin_ns = self.now_ns = stamp_ns
        elif self.now_ns <= stamp_ns <= self.now_ns + _LARGEST_STEP_NS:
            self.now_ns = stamp_ns

    def place(self, stamp_ns: int) -> int:
        """Return the time of a message by its stamp: the newest own time for one that is off the line."""
        if self.begin_ns is None:
            return stamp_ns
        is_on_line = self.begin_ns <= stamp_ns <= self.now_ns + _SLACK_NS + _LEAD_TICKS * self._tick_ns
        return stamp_ns if is_on_line else self.now_ns
