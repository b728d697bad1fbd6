"""What went wrong: with one of many jobs, while the others go on, or with a whole command."""

from __future__ import annotations

import os
import sys
import tempfile
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from auv_bringup.interrupts import make_signals_interrupt
from auv_bringup.one_line_parser import fail

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
"""Exit statuses that all commands have."""


@dataclass(frozen=True)
class Failure:
    """A job that raised: what in one line, and its traceback."""

    line: str
    traceback: str

    @classmethod
    def of(cls, error: BaseException) -> Failure:
        """Return what to remember of an exception."""
        return cls(one_line(error), "".join(traceback.format_exception(error)))


def one_line(error: BaseException) -> str:
    """Return kind and message of an exception on one line."""
    return f"{type(error).__name__}: {' '.join(str(error).split()) or 'no message'}"


def internal_error(error: BaseException, folder: Path | None = None) -> str:
    """
    Write the traceback of an error that nobody expected into `folder`, or to a temporary file where there is
    none; return one line about it.
    """
    lines = traceback.format_exception(error)
    if folder is not None and folder.is_dir():
        path = folder / "traceback.txt"
        path.write_text("".join(lines), encoding="utf-8")
        return f"{one_line(error)}; the traceback is in {path}"
    with tempfile.NamedTemporaryFile("w", prefix="shoal-", suffix=".traceback.txt", delete=False) as stream:
        stream.writelines(lines)
    return f"{one_line(error)}; the traceback is in {stream.name}"


def answered(
    command: Callable[[], int],
    refused: tuple[type[Exception], ...],
    *,
    interrupted: str = "interrupted; finished runs are kept for the next call",
    explained: Callable[[Exception], str] = internal_error,
) -> int:
    """
    Return the exit status of a command, and say in one line what went wrong.

    Parameters
    ----------
    command : callable
        Does the work and returns the status.
    refused : tuple of exception types
        Errors that are bad input.
    interrupted : str
        What to say after Ctrl-C.
    explained : callable
        Returns what to say of any other error.

    """
    make_signals_interrupt()
    try:
        return command()
    except refused as error:
        return fail(BAD_INPUT, str(error))
    except KeyboardInterrupt:
        return fail(INTERRUPTED, interrupted)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except Exception as error:
        return fail(FAILED, explained(error))
