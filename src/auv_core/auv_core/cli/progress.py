"""
Progress of a flight: simulated time, rate relative to real time, time left.

It is a bar on a terminal, and otherwise an occasional line.
"""

from __future__ import annotations

import math
import time
from typing import TextIO

from auv_core.cli.terminal_bar import TerminalBar

_LINE_EVERY_S = 10.0
_RATE_WINDOW_S = 10.0


class Progress(TerminalBar):
    """
    Progress of one flight on standard error.

    Messages are printed through it, too, so that they do not break the bar.
    """

    def __init__(self, duration_s: float, stream: TextIO | None = None, *, verb: str = "simulated") -> None:
        super().__init__(stream)
        self._duration_s = duration_s
        self._verb = verb
        self._laps: list[tuple[float, float]] = []
        self._line_at_s = math.inf

    def update(self, time_s: float) -> None:
        """Show that the flight has reached `time_s` (s, scenario time)."""
        now_s = time.monotonic()
        if not self._laps:
            self._line_at_s = now_s + _LINE_EVERY_S
        self._laps.append((time_s, now_s))
        while now_s - self._laps[0][1] > _RATE_WINDOW_S and len(self._laps) > 2:
            del self._laps[0]
        if self._stream.isatty():
            self._draw(time_s)
        elif now_s >= self._line_at_s:
            self._line_at_s = now_s + _LINE_EVERY_S
            self.message(f"{time_s:.0f} of {self._duration_s:.0f} s {self._verb}, {self._rate_words(time_s)}")

    def _draw(self, time_s: float) -> None:
        if self._bar is None:
            self._bar = self._make_bar(self._duration_s)
        words = f"{time_s:.0f} of {self._duration_s:.0f} s, {self._rate_words(time_s)}"
        self._show(min(time_s, self._duration_s), words)

    def _rate_words(self, time_s: float) -> str:
        first_s, wall_first_s = self._laps[0]
        last_s, wall_last_s = self._laps[-1]
        if last_s <= first_s or wall_last_s <= wall_first_s:
            return "rate not known yet"
        rate = (last_s - first_s) / (wall_last_s - wall_first_s)
        left_s = math.ceil(max(self._duration_s - time_s, 0.0) / rate)
        return f"{rate:.1f} x real time, {left_s // 60}:{left_s % 60:02d} left"
