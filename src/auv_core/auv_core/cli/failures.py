"""How a command ends after an error."""

from __future__ import annotations

import os
import sys
import tempfile
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from auv_core.cli.one_line_parser import fail
from auv_core.cli.standard_streams import lasting_output, make_output_printable
from auv_core.machine.failure import one_line
from auv_core.machine.interrupts import make_signals_interrupt
from auv_core.machine.whole_files import WriteError, is_no_room, write_error

DONE, FAILED, BAD_INPUT, NOT_WRITTEN, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit statuses of all commands; NOT_WRITTEN: a result cannot be written, as on a full disk."""


def internal_error(error: BaseException, folder: Path | None = None) -> str:
    """
    Write the traceback of an unexpected error into `folder`, or into a temporary file if that fails; return
    one line about it.
    """
    text = "".join(traceback.format_exception(error))
    try:
        place = _write_traceback(text, folder)
    except OSError as problem:  # the disk that caused the error may not take the traceback either
        return (
            f"{one_line(error)}, at {_place_of(error)}; the traceback cannot be written ({problem.strerror})"
        )
    return f"{one_line(error)}; the traceback is in {place}"


def _write_traceback(text: str, folder: Path | None) -> str:
    if folder is not None:
        path = folder / "traceback.txt"
        with suppress(OSError):
            path.write_text(text, encoding="utf-8")
            return str(path)
    with tempfile.NamedTemporaryFile(
        "w", prefix="shoal-", suffix=".traceback.txt", delete=False, encoding="utf-8"
    ) as stream:
        stream.write(text)
    return stream.name


def _place_of(error: BaseException) -> str:
    """Return file and line where an exception was raised."""
    frames = traceback.extract_tb(error.__traceback__)
    return f"{frames[-1].filename}:{frames[-1].lineno}" if frames else "an unknown place"


def answered(
    command: Callable[[], int],
    refused: tuple[type[Exception], ...],
    *,
    interrupted: str = "interrupted; finished runs are kept for the next call",
    explained: Callable[[Exception], str] = internal_error,
    outlives_its_reader: bool = True,
    failed: int = FAILED,
) -> int:
    """
    Return the exit status of a command, and print one line about an error.

    Parameters
    ----------
    command : callable
        Does the work and returns the status.
    refused : tuple of exception types
        Exceptions that mean bad input.
    interrupted : str
        Text to print after Ctrl-C; '' for none.
    explained : callable
        Returns the text for any other error.
    outlives_its_reader : bool
        Whether the command continues when its output is closed: a closed terminal, `| head`.
    failed : int
        The status of any other error.

    """
    make_signals_interrupt()
    make_output_printable()
    if not outlives_its_reader:
        return _status_of(command, refused, interrupted, explained, failed)
    with lasting_output() as output:
        status = _status_of(command, refused, interrupted, explained, failed)
        output.flush()
        if status == DONE and output.error is not None:
            return fail(NOT_WRITTEN, str(write_error("standard output", output.error)))
        return status


def _status_of(
    command: Callable[[], int],
    refused: tuple[type[Exception], ...],
    interrupted: str,
    explained: Callable[[Exception], str],
    failed: int,
) -> int:
    try:
        return command()
    except refused as error:
        return fail(BAD_INPUT, str(error))
    except KeyboardInterrupt:
        return fail(INTERRUPTED, interrupted) if interrupted else INTERRUPTED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except WriteError as error:
        return fail(NOT_WRITTEN, str(error))
    except Exception as error:
        if isinstance(error, OSError) and is_no_room(error):
            return fail(NOT_WRITTEN, str(write_error(error.filename or "a file", error)))
        return fail(failed, explained(error))
