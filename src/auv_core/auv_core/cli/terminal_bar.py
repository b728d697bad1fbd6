"""Common part of the progress displays: a bar on a terminal, and lines that do not break it."""

from __future__ import annotations

import sys
from types import TracebackType
from typing import Self, TextIO

from tqdm import tqdm

from auv_core.cli.printable import printable


class TerminalBar:
    """A bar on standard error, drawn by a subclass if the stream is a terminal; a context manager."""

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = stream or sys.stderr
        self._bar: tqdm | None = None

    def message(self, line: str) -> None:
        """Print a line above the bar."""
        line = printable(line)
        if self._bar is not None:
            self._bar.write(line, file=self._stream)
        else:
            self._stream.write(line + "\n")
            self._stream.flush()

    def close(self) -> None:
        """Leave the bar as it is and end its line."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _make_bar(self, total: float) -> tqdm:
        return tqdm(
            total=total,
            file=self._stream,
            dynamic_ncols=True,
            bar_format="{percentage:3.0f} % |{bar}| {desc}",
        )

    def _show(self, done: float, words: str) -> None:
        """Draw the bar, which must exist, at `done` of its total, with `words` beside it."""
        if self._bar is not None:
            self._bar.n = done
            self._bar.set_description_str(words, refresh=False)
            self._bar.refresh()
