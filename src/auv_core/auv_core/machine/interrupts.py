"""Signals that ask a command to end."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType
from typing import Any, NoReturn

SIGNALS = tuple(signal.Signals[name] for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Signals that ask a command to end, as far as the system has them."""


class Interrupted(KeyboardInterrupt):
    """
    Raised when a signal asks the command to end.

    It has its own class because of CPython: after a plain KeyboardInterrupt inside an exec() of text, which
    dataclasses use at import, CPython ends by SIGINT although the exception was caught.
    """


def heeded_signals() -> list[signal.Signals]:
    """
    Return `SIGNALS` without those that were ignored when the command started (`nohup`, `trap '' HUP`).

    SIGINT is always obeyed, since a shell script sets it to ignored for all background commands.
    """
    return [
        number
        for number in SIGNALS
        if number == signal.SIGINT or signal.getsignal(number) is not signal.SIG_IGN
    ]


def make_signals_interrupt() -> None:
    """Let the signals that are obeyed raise KeyboardInterrupt."""

    def interrupt(number: int, frame: FrameType | None) -> NoReturn:
        del number, frame
        raise Interrupted

    for number in heeded_signals():
        signal.signal(number, interrupt)


class Interrupts:
    """
    Counts requests to end (Ctrl-C, SIGTERM, SIGHUP) while entered, in place of Python's own handling.
    Signals that were ignored at the start stay ignored.

    The first asks for a clean end, the second for a quick one.
    """

    def __init__(self) -> None:
        self.count = 0
        self._previous: dict[signal.Signals, Any] = {}

    @property
    def is_hurried(self) -> bool:
        """Whether the end was asked for more than once."""
        return self.count > 1

    def __enter__(self) -> Interrupts:
        for number in heeded_signals():
            self._previous[number] = signal.signal(number, self._on_signal)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        for number, handler in self._previous.items():
            signal.signal(number, handler)

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self.count += 1


@contextmanager
def held_interrupts() -> Iterator[None]:
    """
    Delay signals that ask for the end until after the block: rclpy objects that are only half made would
    print errors.
    """
    with Interrupts() as interrupts:
        yield
    if interrupts.count:
        raise Interrupted
