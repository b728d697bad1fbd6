"""Duration of a topic's silence: reported from time to time, and limited."""

from __future__ import annotations

from collections.abc import Callable

SAY_S = 5.0
"""Time between two lines about a wait (s)."""


class Silence:
    """
    A silence that starts now, and again with each message.

    Parameters
    ----------
    limit_s : float
        Longest silence (s).
    clock_s : callable
        The steady clock (s).

    """

    def __init__(self, limit_s: float, clock_s: Callable[[], float]) -> None:
        self._limit_s = limit_s
        self._clock_s = clock_s
        self.end()

    def end(self) -> None:
        """Note a message."""
        self._began_s = self._clock_s()
        self._said_at_s = 0.0

    @property
    def lasts_s(self) -> float:
        """Its duration so far (s)."""
        return self._clock_s() - self._began_s

    @property
    def is_too_long(self) -> bool:
        """Whether it has reached the limit."""
        return self.lasts_s >= self._limit_s

    def is_to_be_said(self) -> bool:
        """Return whether a report is due: every `SAY_S`, and at the limit."""
        lasts_s = self.lasts_s
        is_due = lasts_s >= self._said_at_s + SAY_S
        if is_due:
            self._said_at_s = lasts_s
        return is_due or self.is_too_long
