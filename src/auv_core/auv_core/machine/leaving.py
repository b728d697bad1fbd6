"""
The end of a process in which the system clock was stepped.

To end the middleware cleanly is to wait for its threads, which wait until times of the system clock.
Where a step holds them, that has no end, and Python stands still.
"""

from __future__ import annotations

import os
import sys
from typing import Any, NoReturn

_kept: list[Any] = []


def keep(*parts: Any) -> None:
    """Keep objects of the middleware as they are until the process ends, see `leave_if_kept`."""
    _kept.extend(parts)


def leave_if_kept(status: int) -> int:
    """End the process at once where objects were kept; else return the exit status."""
    return leave(status) if _kept else status


def leave(status: int) -> NoReturn:
    """End the process with an exit status, without an end of the middleware."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)
