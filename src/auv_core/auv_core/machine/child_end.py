"""How a child process ended, as text, and its last output."""

from __future__ import annotations

import os
import signal
from collections import deque
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Exit:
    """A child that has ended: its name and return code (exit status, or minus the signal number)."""

    name: str
    returncode: int

    @property
    def words(self) -> str:
        """How it ended, for people."""
        if self.returncode < 0:
            return f"killed by {signal_name(-self.returncode)}"
        return f"exit status {self.returncode}"


def signal_name(number: int) -> str:
    """Return the name of a signal: 'SIGKILL' for 9."""
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def last_lines(log: Path, count: int = 5, most_bytes: int = 8192) -> list[str]:
    """Return the last lines of a log that are not blank, [] if there are none."""
    try:
        with log.open("rb") as stream:
            stream.seek(0, os.SEEK_END)
            stream.seek(max(0, stream.tell() - most_bytes))
            text = stream.read().decode("utf-8", errors="replace")
    except OSError:
        return []
    return list(deque((line.rstrip() for line in text.splitlines() if line.strip()), maxlen=count))
