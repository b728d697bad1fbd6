"""How far a set of jobs is: a bar on a terminal, elsewhere a line now and then."""

from __future__ import annotations

import math
import sys
import time
from types import TracebackType
from typing import TextIO

from tqdm import tqdm

from auv_bringup.reproduction.workers import Failure

_LINE_EVERY_S = 15.0


class Tally:
    """
    Progress of many jobs on standard error, weighed by their expected effort.

    A context manager; `what` names the jobs in the plural.
    """

    def __init__(self, what: str, stream: TextIO | None = None) -> None:
        self._what = what
        self._stream = stream or sys.stderr
        self._bar: tqdm | None = None
        self._jobs = self._finished = 0
        self._total = self._done = 0.0
        self._started_s = self._line_at_s = 0.0

    def start(self, jobs: int, total: float, remark: str = "") -> None:
        """Begin: so many jobs are to be done, of this effort together."""
        self._jobs, self._total = jobs, total
        self._started_s = time.monotonic()
        self._line_at_s = self._started_s + _LINE_EVERY_S
        self.message(f"{self._what}: {jobs}{remark}")
        if jobs and self._stream.isatty():
            tqdm.monitor_interval = 0  # no thread of its own: workers are forked after this
            self._bar = tqdm(
                total=total,
                file=self._stream,
                dynamic_ncols=True,
                bar_format="{percentage:3.0f} % |{bar}| {desc}",
            )

    def advance(self, done: float) -> None:
        """Show that so much of the effort is behind us."""
        self._done = min(done, self._total)
        now_s = time.monotonic()
        if self._bar is not None:
            self._bar.n = self._done
            self._bar.set_description_str(self._words(now_s), refresh=False)
            self._bar.refresh()
        elif now_s >= self._line_at_s:
            self._line_at_s = now_s + _LINE_EVERY_S
            self.message(self._words(now_s))

    def finished(self) -> None:
        """Count a job that has ended."""
        self._finished += 1

    def failed(self, job: str, failure: Failure) -> None:
        """Say that a job failed, and why."""
        self.message(f"error: {job}: {failure.line}")

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

    def __enter__(self) -> Tally:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _words(self, now_s: float) -> str:
        words = f"{self._finished} of {self._jobs} {self._what}"
        share = self._done / self._total if self._total > 0.0 else 0.0
        if share < 0.02:
            return words
        left_s = math.ceil((now_s - self._started_s) * (1.0 - share) / share)
        return f"{words}, about {left_s // 60}:{left_s % 60:02d} left"
