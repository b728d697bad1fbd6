"""Names of items and verdicts on the page, and their anchors."""

from __future__ import annotations

import html
import re

from auv_thesis.items import (
    AGREES,
    AGREES_IN_PART,
    DIFFERS,
    DOES_NOT_HOLD,
    HOLDS,
    HOLDS_IN_PART,
    NO_NUMBER,
    Claim,
    Item,
)
from auv_thesis.page.made import name_of

_SIGNS = {
    HOLDS: "●",
    HOLDS_IN_PART: "◐",
    DOES_NOT_HOLD: "○",
    AGREES: "●",
    AGREES_IN_PART: "◐",
    DIFFERS: "○",
    NO_NUMBER: "–",
}


def mark(word: str) -> str:
    """Return a verdict with its sign."""
    return f"<b class='mark'><span aria-hidden='true'>{_SIGNS[word]}</span> {word}</b>"


def heading(item: Item) -> str:
    """Return the line above a table or a figure."""
    title = "" if isinstance(item, Claim) else f". {item.title}"
    return f"{capital(name_of(item))}{title}"


def capital(text: str) -> str:
    """Return a text with a capital first letter."""
    return text[:1].upper() + text[1:]


def place_of(claim: Item) -> str:
    """Return the place of a claim in the thesis; a bare number is a section."""
    return html.escape(f"Section {claim.number}" if claim.number[:1].isdigit() else claim.number)


def text_of(item: Item) -> str:
    """Return the text of a claim, or the title of another item."""
    return item.text if isinstance(item, Claim) else item.title


def anchor(item: Item) -> str:
    """Return the anchor of an item; claims may share a number, so their text is part of it."""
    if isinstance(item, Claim):
        return f"claim-{slug(item.number)}-{slug(item.text)[:60]}"
    return slug(name_of(item))


def slug(text: str) -> str:
    """Return a text as lower-case letters, digits and hyphens."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")
