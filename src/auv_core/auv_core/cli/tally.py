"""Progress of a set of jobs: a bar on a terminal, and otherwise an occasional line."""

from __future__ import annotations

import math
import time
from typing import TextIO

from tqdm import tqdm

from auv_core.cli.terminal_bar import TerminalBar
from auv_core.machine.failure import Failure

_LINE_EVERY_S = 15.0


class Tally(TerminalBar):
    """
    Progress of many jobs on standard error, weighted by their expected effort.

    A context manager; `what` names the jobs in the plural.
    """

    def __init__(self, what: str, stream: TextIO | None = None) -> None:
        super().__init__(stream)
        self._what = what
        self._jobs = self._finished = 0
        self._total = self._done = 0.0
        self._started_s = self._line_at_s = 0.0

    def start(self, jobs: int, total: float, remark: str = "") -> None:
        """Begin with this number of jobs and this total effort."""
        self._jobs, self._total = jobs, total
        self._started_s = time.monotonic()
        self._line_at_s = self._started_s + _LINE_EVERY_S
        self.message(f"{self._what}: {jobs}{remark}")
        if jobs and self._stream.isatty():
            tqdm.monitor_interval = 0  # no monitor thread: workers are forked after this
            self._bar = self._make_bar(total)

    def advance(self, done: float) -> None:
        """Show that this part of the effort is done."""
        self._done = min(done, self._total)
        now_s = time.monotonic()
        if self._bar is not None:
            self._show(self._done, self._words(now_s))
        elif now_s >= self._line_at_s:
            self._line_at_s = now_s + _LINE_EVERY_S
            self.message(self._words(now_s))

    def finished(self) -> None:
        """Count a job that has ended."""
        self._finished += 1

    def failed(self, job: str, failure: Failure) -> None:
        """Print that a job failed, and why."""
        self.message(f"error: {job}: {failure.line}")

    def _words(self, now_s: float) -> str:
        words = f"{self._finished} of {self._jobs} {self._what}"
        share = self._done / self._total if self._total > 0.0 else 0.0
        if share < 0.02:
            return words
        left_s = math.ceil((now_s - self._started_s) * (1.0 - share) / share)
        return f"{words}, about {left_s // 60}:{left_s % 60:02d} left"
