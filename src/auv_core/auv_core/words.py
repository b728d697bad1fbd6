"""Lists of names in messages."""

from __future__ import annotations

from collections.abc import Sequence

_MOST_NAMES = 10


def listed(names: Sequence[str]) -> str:
    """Return names as text, the first few if there are many."""
    more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
    return ", ".join(names[:_MOST_NAMES]) + more
