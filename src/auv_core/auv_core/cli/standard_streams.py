"""Standard output and error that never end a command, whatever their encoding and even if they are closed."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO, cast

_NOBODY_READS = (errno.EPIPE, errno.EIO)


class LastingStream:
    """
    A text stream that survives a failed write: after it, all text is dropped.

    All other attributes are those of the stream.

    Attributes
    ----------
    error : OSError, optional
        Why text was dropped, unless the terminal or the pipe was closed.

    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.error: OSError | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text, or drop it."""
        try:
            return self._stream.write(text)
        except OSError as error:
            self._drop_from_now_on(error)
            return len(text)

    def flush(self) -> None:
        """Flush, or drop the buffered text."""
        try:
            self._stream.flush()
        except OSError as error:
            self._drop_from_now_on(error)

    def _drop_from_now_on(self, error: OSError) -> None:
        if error.errno not in _NOBODY_READS:
            self.error = error
        with suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())  # Python flushes the rest here, also at exit
            os.close(nowhere)


@contextmanager
def lasting_output() -> Iterator[LastingStream]:
    """
    Let standard output (the argument) and standard error survive the loss of their terminal, pipe or disk.
    """
    before = sys.stdout, sys.stderr
    output, errors = LastingStream(sys.stdout), LastingStream(sys.stderr)
    sys.stdout, sys.stderr = cast(TextIO, output), cast(TextIO, errors)
    try:
        yield output
    finally:
        output.flush()
        errors.flush()
        sys.stdout, sys.stderr = before


def make_output_printable() -> None:
    """Let standard output and error escape characters that their encoding lacks, as in an ASCII terminal."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
