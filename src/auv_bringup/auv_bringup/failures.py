"""What went wrong with one of many jobs, while the others go on."""

from __future__ import annotations

import os
import sys
import tempfile
import traceback
from collections.abc import Callable
from dataclasses import dataclass

from auv_bringup.interrupts import make_signals_interrupt
from auv_bringup.one_line_parser import fail

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
"""Exit statuses of commands that fly many runs."""


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


def internal_error(error: BaseException) -> str:
    """Write the traceback of an error that nobody expected to a temporary file; return one line about it."""
    with tempfile.NamedTemporaryFile("w", prefix="shoal-", suffix=".traceback.txt", delete=False) as stream:
        stream.writelines(traceback.format_exception(error))
    return f"{one_line(error)}; the traceback is in {stream.name}"


def answered(command: Callable[[], int], refused: tuple[type[Exception], ...]) -> int:
    """
    Return the exit status of a command that flies many runs, and say in one line what went wrong; errors of
    the kinds `refused` are bad input.
    """
    make_signals_interrupt()
    try:
        return command()
    except refused as error:
        return fail(BAD_INPUT, str(error))
    except KeyboardInterrupt:
        return fail(INTERRUPTED, "interrupted; finished runs are kept for the next call")
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except Exception as error:
        return fail(FAILED, internal_error(error))
