"""
JSON files of kept runs, each with a checksum of its name and its content.

The checksum reveals files that were changed, truncated or renamed. It does not protect against a person who
computes a new checksum, so the content is treated as data only.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import stat
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from auv_core.machine.whole_files import write_text

_CHECKSUM = "checksum"
_MOST_BYTES = 1 << 24


class KeptError(ValueError):
    """Raised for a damaged kept file; the message is a short reason."""


def write_kept(path: Path, name: str, known: dict[str, Any]) -> None:
    """Write the data of the run `name` completely or not at all; raise WriteError if that fails."""
    text = json.dumps({**known, _CHECKSUM: _checksum(name, known)}, indent=1, allow_nan=False)
    write_text(path, text + "\n")


def read_kept(path: Path, name: str) -> dict[str, Any]:
    """
    Return the data that `write_kept` wrote.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    KeptError
        If it is not the file that was written under this name.

    """
    try:
        known = json.loads(_read(path), parse_constant=_refuse)
        if not isinstance(known, dict) or known.pop(_CHECKSUM, None) != _checksum(name, known):
            raise KeptError("its checksum is wrong")
    except FileNotFoundError:
        raise
    except OSError as error:
        raise KeptError(error.strerror or str(error)) from None
    except (ValueError, RecursionError) as error:
        raise KeptError(str(error)) from None
    return known


def remove(path: Path) -> None:
    """Remove a file, a link or a folder if it exists; ignore failures."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    with suppress(OSError):
        path.unlink()


def words_of_broken(files: Sequence[str]) -> str:
    """Return one line about damaged kept runs, each with the reason."""
    more = f" and {len(files) - 1} more" if len(files) > 1 else ""
    return f"kept runs were changed or damaged and are flown again: {files[0]}{more}"


def file_checksum(path: Path) -> str:
    """Return the checksum of a file's content."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _checksum(name: str, known: dict[str, Any]) -> str:
    text = json.dumps([name, known], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def _read(path: Path) -> bytes:
    """Return the content of a plain file; refuse anything else, such as a FIFO, without blocking."""
    with os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW), "rb") as stream:
        if not stat.S_ISREG(os.fstat(stream.fileno()).st_mode):
            raise KeptError("not a plain file")
        data = stream.read(_MOST_BYTES + 1)
    if len(data) > _MOST_BYTES:
        raise KeptError(f"larger than {_MOST_BYTES} bytes")
    return data


def _refuse(word: str) -> None:
    raise KeptError(f"{word} is not a number")
