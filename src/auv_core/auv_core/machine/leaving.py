"""
The end of a process after a step of the system clock.

A clean end of the middleware waits for its threads, and these wait for times of the system clock. After a
step of the clock this may take forever, and Python would hang.
"""

from __future__ import annotations

import os
import sys
from typing import NoReturn


def leave(status: int) -> NoReturn:
    """End the process with an exit status, without ending the middleware."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)
