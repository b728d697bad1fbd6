"""Locks of files that end with the process that holds them, on systems that have such (flock)."""

from __future__ import annotations

try:
    import fcntl
except ImportError:
    fcntl = None  # type: ignore[assignment]


def lock_file(descriptor: int) -> None:
    """
    Hold an open file or folder against others until it is closed; do nothing on a system without such locks.

    Raises
    ------
    BlockingIOError
        When another process holds it.
    OSError
        On a file system that locks nothing.

    """
    if fcntl is not None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
