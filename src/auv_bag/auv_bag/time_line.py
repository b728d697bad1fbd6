"""The time line of a bag: the run's own time, which a wrong stamp cannot extend."""

from __future__ import annotations

_SLACK_NS = 10_000_000_000
"""How far a stamp may be ahead of the newest own time; clocks of several machines differ slightly."""
_LEAD_TICKS = 250
"""How many ticks lock-step may be ahead of its recorder."""
_LARGEST_STEP_NS = 3600 * 1_000_000_000


class TimeLine:
    """
    The time of a run from its clock node.

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
        """Take a time of the clock node; a time far from the last one does not belong to the run."""
        if self.begin_ns is None:
            self.begin_ns = self.now_ns = stamp_ns
        elif self.now_ns <= stamp_ns <= self.now_ns + _LARGEST_STEP_NS:
            self.now_ns = stamp_ns

    def place(self, stamp_ns: int) -> int:
        """
        Return the time of a message from its stamp: the newest own time if the stamp is off the time line.
        """
        if self.begin_ns is None:
            return stamp_ns
        is_on_line = self.begin_ns <= stamp_ns <= self.now_ns + _SLACK_NS + _LEAD_TICKS * self._tick_ns
        return stamp_ns if is_on_line else self.now_ns
