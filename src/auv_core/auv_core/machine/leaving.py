"""
The end of a process in which the system clock was stepped.

To end the middleware cleanly is to wait for its threads, which wait until times of the system clock.
Where a step holds them, that has no end, and Python stands still.
"""

from __future__ import annotations

import os
import sys
from typing import NoReturn


def leave(status: int) -> NoReturn:
    """End the process with an exit status, without an end of the middleware."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)
