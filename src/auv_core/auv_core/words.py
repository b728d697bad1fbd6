"""Names in lines for people."""

from __future__ import annotations

from collections.abc import Sequence

_MOST_NAMES = 10


def listed(names: Sequence[str]) -> str:
    """Return names for people, the first few of many."""
    more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
    return ", ".join(names[:_MOST_NAMES]) + more
