"""Safe text for a terminal: text from other programs must not move its cursor or change its colours."""

from __future__ import annotations


def printable(text: str) -> str:
    """Return a text in which control characters are escaped, except tabs and line ends."""
    return "".join(
        letter if letter.isprintable() or letter in "\n\t" else letter.encode("unicode_escape").decode()
        for letter in text
    )
