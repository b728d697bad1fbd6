"""Command-line parser that reports bad arguments in one line."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from typing import NoReturn, TypeVar

from auv_core.cli.printable import printable
from auv_core.params import shown

T = TypeVar("T")

BAD_ARGUMENTS = 2
"""Exit status for arguments that are not allowed."""
MOST_WORKERS = 256
"""Largest number of processes that a command starts on this machine."""


_SCRIPTS = "./scripts/"
_called_as = _SCRIPTS


def call_commands(prefix: str) -> None:
    """From now on print `prefix` before the name of a command instead of ``./scripts/``."""
    global _called_as
    _called_as = prefix


class OneLineParser(argparse.ArgumentParser):
    """A parser whose errors are one line; this holds for its subcommands, too."""

    def format_help(self) -> str:
        """Return the help."""
        return _named(super().format_help())

    def error(self, message: str) -> NoReturn:
        """End the program with an error line."""
        self.exit(
            BAD_ARGUMENTS, f"error: {' '.join(message.split())} ({_named(self.prog)} --help says more)\n"
        )


def _named(text: str) -> str:
    """Return a text with the commands' names as the user typed them."""
    return text.replace(_SCRIPTS, _called_as)


def refusal(text: str, allowed: str) -> argparse.ArgumentTypeError:
    """Return the error that an argument's type function raises: the given value, and what is allowed."""
    return argparse.ArgumentTypeError(f"{shown(text)} is not allowed; allowed: {allowed}")


def read_argument(text: str, kind: Callable[[str], T], is_allowed: Callable[[T], bool], allowed: str) -> T:
    """Return the value of an argument, or refuse it with a text that says what is allowed."""
    try:
        value = kind(text)
    except ValueError:
        raise refusal(text, allowed) from None
    if not is_allowed(value):
        raise refusal(text, allowed)
    return value


def whole_number(text: str, most: int) -> int:
    """Return a whole number from 1 to `most`; for an argument's type function."""
    return read_argument(text, int, lambda value: 1 <= value <= most, f"a whole number from 1 to {most}")


def fail(status: int, line: str) -> int:
    """Print an error line on standard error; return `status`, the exit status for it."""
    sys.stderr.write(f"error: {printable(_named(line))}\n")
    sys.stderr.flush()
    return status
