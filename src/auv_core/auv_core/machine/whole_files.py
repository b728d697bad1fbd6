"""Files that are written completely or not at all: first beside their place, then renamed."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


class WriteError(OSError):
    """Raised if a file cannot be written; the message is one line with the file and the reason."""


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """
    Yield the path of a new file for the block to write; it becomes `path` if the block ends without error.

    After an error the new file is removed, and the old file at `path` is unchanged. The new file has the
    suffix of `path`, since some libraries choose the format by it.

    Raises
    ------
    WriteError
        If the block or the renaming fails with an OSError.

    """
    unfinished = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        yield unfinished
        unfinished.replace(path)
    except OSError as error:
        raise write_error(path, error) from error
    finally:
        with suppress(OSError):
            unfinished.unlink()


def write_text(path: Path, text: str) -> None:
    """Write a text file (UTF-8) completely or not at all; raise WriteError if that fails."""
    with whole_file(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8")


def write_bytes(path: Path, data: bytes) -> None:
    """Write a file completely or not at all; raise WriteError if that fails."""
    with whole_file(path) as unfinished:
        unfinished.write_bytes(data)


def reserve(path: Path, room_bytes: int) -> None:
    """Reserve disk space beside `path` for `write_reserved`; raise WriteError if there is none."""
    reserved = _reserved(path)
    try:
        with reserved.open("wb") as stream:
            if hasattr(os, "posix_fallocate"):
                os.posix_fallocate(stream.fileno(), 0, room_bytes)
            else:
                stream.write(bytes(room_bytes))
    except OSError as error:
        reserved.unlink(missing_ok=True)
        raise write_error(path, error) from error


def write_reserved(path: Path, text: str) -> None:
    """
    Write a text file like `write_text`, in the disk space that was reserved for it: the disk may be full.
    """
    data = text.encode()
    with whole_file(path) as unfinished:
        with suppress(FileNotFoundError):  # nothing was reserved
            _reserved(path).replace(unfinished)
        with os.fdopen(os.open(unfinished, os.O_WRONLY | os.O_CREAT, 0o666), "wb") as stream:
            stream.write(data)
            stream.truncate()


def _reserved(path: Path) -> Path:
    return path.with_name(f".{path.stem}.reserved{path.suffix}")


def write_error(path: Path | str, error: OSError) -> WriteError:
    """Return an error with one line that says why `path` cannot be written."""
    return WriteError(f"cannot write {path}: {reason(error)}")


def reason(error: OSError) -> str:
    """Return in words why a file or folder cannot be written."""
    if isinstance(error, FileNotFoundError):
        return "its folder is gone: it was moved or removed"
    return error.strerror or str(error)


def is_no_room(error: OSError) -> bool:
    """Return whether an error means that the disk is full, or that a quota or a limit is reached."""
    return error.errno in _NO_ROOM
