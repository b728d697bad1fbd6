"""
How far a flight is: simulated time, rate against real time, time left.

A bar on a terminal; elsewhere a line now and then.
"""

from __future__ import annotations

import math
import sys
import time
from types import TracebackType
from typing import TextIO

from tqdm import tqdm

_LINE_EVERY_S = 10.0
_RATE_WINDOW_S = 10.0


class Progress:
    """
    Progress of one flight on standard error.

    Messages go through it too, so that they do not tear the bar.
    """

    def __init__(self, duration_s: float, stream: TextIO | None = None) -> None:
        self._duration_s = duration_s
        self._stream = stream or sys.stderr
        self._laps: list[tuple[float, float]] = []
        self._line_at_s = math.inf
        self._bar: tqdm | None = None

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
            self.message(f"{time_s:.0f} of {self._duration_s:.0f} s simulated, {self._rate_words(time_s)}")

    def message(self, line: str) -> None:
        """Print a line above the bar."""
        if self._bar is not None:
            self._bar.write(line, file=self._stream)
        else:
            self._stream.write(line + "\n")
            self._stream.flush()

    def close(self) -> None:
        """Leave the bar as it is and end its line."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None

    def __enter__(self) -> Progress:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _draw(self, time_s: float) -> None:
        if self._bar is None:
            self._bar = tqdm(
                total=self._duration_s,
                file=self._stream,
                dynamic_ncols=True,
                bar_format="{percentage:3.0f} % |{bar}| {desc}",
            )
        self._bar.n = min(time_s, self._duration_s)
        self._bar.set_description_str(
            f"{time_s:.0f} of {self._duration_s:.0f} s, {self._rate_words(time_s)}", refresh=False
        )
        self._bar.refresh()

    def _rate_words(self, time_s: float) -> str:
        first_s, wall_first_s = self._laps[0]
        last_s, wall_last_s = self._laps[-1]
        if last_s <= first_s or wall_last_s <= wall_first_s:
            return "rate not known yet"
        rate = (last_s - first_s) / (wall_last_s - wall_first_s)
        left_s = math.ceil(max(self._duration_s - time_s, 0.0) / rate)
        return f"{rate:.1f} x real time, {left_s // 60}:{left_s % 60:02d} left"
