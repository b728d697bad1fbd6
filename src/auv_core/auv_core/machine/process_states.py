"""States of other processes on Linux: whether they are stopped, and which processes they have started."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

_PR_SET_CHILD_SUBREAPER = 36
_libc = ctypes.CDLL(None, use_errno=True)


def is_stopped(pid: int) -> bool:
    """Return whether a process is stopped by a signal (SIGSTOP, Ctrl-Z); false if it has ended."""
    return _read(f"/proc/{pid}/stat").rpartition(b")")[2][1:2] == b"T"


def children_of(pid: int) -> list[int]:
    """
    Return the ids of the direct children of a process's first thread.

    To visit all threads would take five times as long, and this is called for every node twice a second.
    """
    return [int(word) for word in _read(f"/proc/{pid}/task/{pid}/children").split()]


def family_of(pid: int) -> Iterator[int]:
    """Yield the ids of a process and of all its descendants."""
    yield pid
    for child in children_of(pid):
        yield from family_of(child)


def module_of(pid: int) -> str:
    """Return the Python module that a process runs, or the name of its program."""
    try:
        words = Path(f"/proc/{pid}/cmdline").read_text(encoding="utf-8", errors="replace").split("\0")
    except OSError:
        return str(pid)
    return words[words.index("-m") + 1] if "-m" in words[:-1] else words[0]


def adopt_orphans() -> None:
    """Become the parent of every descendant whose parent ends, so that none is lost."""
    _libc.prctl(_PR_SET_CHILD_SUBREAPER, 1)


def orphans() -> list[int]:
    """
    Return the ids of adopted processes that lead a session.

    Running children of this process are among them.
    """
    own_session = os.getsid(0)
    found = []
    for thread in Path("/proc/self/task").iterdir():
        for word in _read(f"{thread}/children").split():
            with suppress(ProcessLookupError):
                if os.getsid(int(word)) != own_session:
                    found.append(int(word))
    return found


def _read(path: str) -> bytes:
    """Return a file of /proc, b'' if its process is gone."""
    try:
        with open(path, "rb") as file:  # noqa: PTH123 - half the time of a Path
            return file.read()
    except OSError:
        return b""
