"""
Causes why an agent holds, that is gives the safe command (no force, or no velocity) instead of its law's.

The text of a hold begins with its cause, so that recorded texts can be counted by cause. A vehicle without a
fresh command rests, which has the same effect; in a bag this is the last cause.
"""

from __future__ import annotations

STALE_NAVIGATION = "stale navigation"
BAD_NAVIGATION = "unusable navigation"
SILENT_MODEM = "silent modem"
OUT_OF_REPORT = "position beyond the report"
NO_FINITE_COMMAND = "no finite command from the law"
FAILED = "failed computer"
STALE_COMMAND = "stale command"

CAUSES = (
    STALE_NAVIGATION,
    BAD_NAVIGATION,
    SILENT_MODEM,
    OUT_OF_REPORT,
    NO_FINITE_COMMAND,
    FAILED,
    STALE_COMMAND,
)


def cause_number(holding: str) -> int:
    """
    Return 0 for an agent that acts, otherwise the position of its cause in `CAUSES` from 1; unknown causes
    are last.
    """
    if not holding:
        return 0
    known = (number for number, cause in enumerate(CAUSES, start=1) if holding.startswith(cause))
    return next(known, len(CAUSES) + 1)
