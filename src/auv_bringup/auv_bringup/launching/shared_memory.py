"""
Removal of shared memory of Fast DDS that killed processes have left.

Fast DDS keeps files in /dev/shm: a segment ``fastrtps_<hex>`` for each participant, and ``fastrtps_port<N>``
and a semaphore for each port with a listener. The owner of a segment or the listener at a port holds a lock
(flock) on a file beside it, ``..._el`` or ``..._sl``, and the kernel always drops that lock when the process
ends. So if the lock is free, the owner is dead; `fastdds shm clean` uses the same rule. A port without a lock
file was opened for sending; it is dead if no process other than this one has mapped it (Fast DDS keeps such
ports mapped after the last participant has ended).
"""

from __future__ import annotations

import fcntl
import os
import re
import time
from collections import defaultdict
from collections.abc import Iterable
from contextlib import ExitStack, suppress
from pathlib import Path

SHARED_MEMORY = Path("/dev/shm")  # noqa: S108 - the folder of Linux
_FILE = re.compile(r"(?:sem\.)?(?P<owner>fast(?:rtps|dds)_(?:port)?[0-9a-f]+)(?:_(?P<kind>el|sl|mutex))?")
_MAPPED = re.compile(r"^\S+ \S+ \S+ ([0-9a-f]+):([0-9a-f]+) (\d+) .*fast(?:rtps|dds)_", re.MULTILINE)
_OPENING_S = 0.1
"""Longest time (s) until a process that has made a port has mapped it."""


def clear_shared_memory(folder: Path = SHARED_MEMORY) -> int:
    """
    Remove files that dead processes of this user have left; return their number.

    Files of a running process, or of another user, stay.
    """
    files: dict[str, dict[str, Path]] = defaultdict(dict)
    for path in _own_files(folder):
        found = _FILE.fullmatch(path.name)
        if found:
            files[found["owner"]][found["kind"] or "memory"] = path
    without_lock = {owner for owner, parts in files.items() if not parts.keys() & {"el", "sl"}}
    removed = sum(_remove_if_unlocked(parts) for owner, parts in files.items() if owner not in without_lock)
    if without_lock:
        time.sleep(_OPENING_S)
        mapped = _mapped_files()
        for owner in without_lock:
            if not any(_identity(path) in mapped for path in files[owner].values()):
                removed += _remove(files[owner].values())
    return removed


def _own_files(folder: Path) -> list[Path]:
    """Return this user's files; [] if there is no such folder."""
    try:
        with os.scandir(folder) as entries:
            return [
                Path(entry.path)
                for entry in entries
                if entry.is_file(follow_symlinks=False)
                and entry.stat(follow_symlinks=False).st_uid == os.geteuid()
            ]
    except OSError:
        return []


def _remove_if_unlocked(parts: dict[str, Path]) -> int:
    """Remove the files of an owner if all its locks are free, the lock files last."""
    locks = [parts[kind] for kind in ("el", "sl") if kind in parts]
    with ExitStack() as stack:
        for path in locks:
            if not _lock(path, stack):
                return 0
        return _remove([path for kind, path in parts.items() if kind not in ("el", "sl")]) + _remove(locks)


def _lock(path: Path, stack: ExitStack) -> bool:
    """
    Hold a lock until the stack ends; return False if another process holds it, or the file was replaced.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
        stack.callback(os.close, descriptor)
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return os.fstat(descriptor).st_ino == path.stat().st_ino
    except OSError:
        return False


def _remove(paths: Iterable[Path]) -> int:
    removed = 0
    for path in paths:
        with suppress(OSError):
            path.unlink()
            removed += 1
    return removed


def _identity(path: Path) -> tuple[int, int] | None:
    """Return device and inode of a file, None if it does not exist."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_dev, found.st_ino


def _mapped_files() -> frozenset[tuple[int, int]]:
    """Return device and inode of the files that another process has mapped."""
    found: set[tuple[int, int]] = set()
    for maps in Path("/proc").glob("[0-9]*/maps"):
        with suppress(OSError):
            if int(maps.parent.name) == os.getpid():
                continue
            for major, minor, inode in _MAPPED.findall(maps.read_text(errors="replace")):
                found.add((os.makedev(int(major, 16), int(minor, 16)), int(inode)))
    return frozenset(found)
