"""The start of a child process: between fork and exec, or as a fork alone."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import NoReturn

from auv_core.machine.interrupts import SIGNALS

_PR_SET_PDEATHSIG = 1
_libc = ctypes.CDLL(None, use_errno=True)


class ForkedChild(multiprocessing.get_context("fork").Process):  # type: ignore[misc]
    """A forked child with the interface of `subprocess.Popen`."""

    def poll(self) -> int | None:
        """Return the exit status, None while it runs."""
        return self.exitcode

    def wait(self, timeout: float) -> int:
        """Wait for the end at most `timeout` (s); return the exit status."""
        self.join(timeout)
        if self.exitcode is None:
            raise subprocess.TimeoutExpired(self.name, timeout)
        return int(self.exitcode)


def schedule_as_batch() -> None:
    """
    Ask Linux not to preempt this thread, or threads that it starts, when they wake another one.

    In lock-step a node wakes others with every message that it publishes, and these need all of its messages
    before they can act.
    """
    with suppress(OSError):  # if not allowed here, the flight takes longer
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))


def threads_allow_fork() -> bool:
    """Return whether this is the only Python thread of the process: a fork would lose the others."""
    return threading.active_count() == 1


def run_forked(run: Callable[[], int], parent_pid: int, log: Path) -> NoReturn:
    """Set up a child: its own session, output to its log, and death together with its parent."""
    os.setsid()
    child_setup(parent_pid)()
    with log.open("ab", buffering=0) as output, Path(os.devnull).open("rb") as nothing:
        os.dup2(nothing.fileno(), 0)
        os.dup2(output.fileno(), 1)
        os.dup2(output.fileno(), 2)
    sys.stdout = os.fdopen(1, "w", buffering=1, encoding="utf-8", errors="backslashreplace")
    sys.stderr = os.fdopen(2, "w", buffering=1, encoding="utf-8", errors="backslashreplace")
    raise SystemExit(run())


def child_setup(parent_pid: int) -> Callable[[], None]:
    """Return the function that a child runs between fork and exec."""

    def setup() -> None:
        _libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent_pid:  # the parent died before the line above
            os._exit(1)
        # A parent that a shell started in the background ignores SIGINT, and a child would inherit that.
        for number in SIGNALS:
            signal.signal(number, signal.SIG_DFL)

    return setup
