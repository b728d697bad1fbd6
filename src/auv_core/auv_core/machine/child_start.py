"""How a child process begins: what it does between fork and exec, or as a fork alone."""

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
    """A forked child in the words of `subprocess.Popen`."""

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
    Ask Linux not to interrupt this thread, nor what it starts, whenever it wakes another.

    A node of a flight in lock-step wakes others with every message that it publishes; they need all of them.
    """
    with suppress(OSError):  # not allowed here: the flight takes longer
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))


def threads_allow_fork() -> bool:
    """Return whether this process has no Python thread but this one: a fork would lose the others."""
    return threading.active_count() == 1


def run_forked(run: Callable[[], int], parent_pid: int, log: Path) -> NoReturn:
    """Be a child: a session of its own, output to its log, this process's death its own."""
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
    """Return what a child does between fork and exec."""

    def setup() -> None:
        _libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent_pid:  # the parent died before the line above
            os._exit(1)
        # A parent started in the background by a shell ignores SIGINT, and a child would inherit that.
        for number in SIGNALS:
            signal.signal(number, signal.SIG_DFL)

    return setup
