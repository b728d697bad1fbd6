"""The failure of one of many jobs, while the others continue."""

from __future__ import annotations

import traceback
from dataclasses import dataclass


@dataclass(frozen=True)
class Failure:
    """A job that raised an exception: one line about it, and its traceback."""

    line: str
    traceback: str

    @classmethod
    def of(cls, error: BaseException) -> Failure:
        """Return the failure for an exception."""
        return cls(one_line(error), "".join(traceback.format_exception(error)))


class WorkersError(RuntimeError):
    """Raised if no worker can run; the message is one line."""


def one_line(error: BaseException) -> str:
    """Return kind and message of an exception on one line."""
    return f"{type(error).__name__}: {' '.join(str(error).split()) or 'no message'}"
