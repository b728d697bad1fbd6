"""Signals that ask a command to end."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""What asks a command to end."""


class Interrupted(KeyboardInterrupt):
    """
    A signal asked for the end.

    Of its own class, since CPython remembers a plain KeyboardInterrupt that hits an exec() of text, as
    dataclasses do while a module is imported, and then ends by SIGINT although it was caught.
    """


def heeded_signals() -> list[signal.Signals]:
    """
    Return `SIGNALS` without those that were ignored when the command started: `nohup` and `trap '' HUP` hold.

    SIGINT is always heeded, since a shell script ignores it for all that it starts in the background.
    """
    return [
        number
        for number in SIGNALS
        if number == signal.SIGINT or signal.getsignal(number) is not signal.SIG_IGN
    ]


def make_signals_interrupt() -> None:
    """Let the signals that are heeded raise KeyboardInterrupt."""

    def interrupt(number: int, frame: FrameType | None) -> NoReturn:
        del number, frame
        raise Interrupted

    for number in heeded_signals():
        signal.signal(number, interrupt)


@contextmanager
def held_interrupts() -> Iterator[None]:
    """Let a signal that asks for the end raise only after the block: half-made objects of rclpy complain."""
    came: list[int] = []
    before = {
        number: signal.signal(number, lambda received, _frame: came.append(received))
        for number in heeded_signals()
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    if came:
        raise Interrupted
