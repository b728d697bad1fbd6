"""Signals that ask a command to end."""

from __future__ import annotations

import signal
from types import FrameType
from typing import NoReturn


class Interrupted(KeyboardInterrupt):
    """
    A signal asked for the end.

    Of its own class, since CPython remembers a plain KeyboardInterrupt that hits an exec() of text, as
    dataclasses do while a module is imported, and then ends by SIGINT although it was caught.
    """


def make_signals_interrupt() -> None:
    """Let SIGINT, SIGTERM and SIGHUP raise KeyboardInterrupt, even in a shell's background."""

    def interrupt(number: int, frame: FrameType | None) -> NoReturn:
        del number, frame
        raise Interrupted

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, interrupt)
