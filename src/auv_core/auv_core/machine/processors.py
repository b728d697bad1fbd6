"""Number of processors for this process."""

from __future__ import annotations

import os


def processor_count() -> int:
    """
    Return the number of processors that this process may use: all, if the system does not restrict them.
    """
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
