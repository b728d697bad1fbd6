"""File locks that end with the process that holds them, on systems that have them (flock)."""

from __future__ import annotations

try:
    import fcntl
except ImportError:
    fcntl = None  # type: ignore[assignment]


def lock_file(descriptor: int) -> None:
    """
    Lock an open file or folder until it is closed; do nothing on a system without such locks.

    Raises
    ------
    BlockingIOError
        If another process holds the lock.
    OSError
        On a file system without locks.

    """
    if fcntl is not None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
