"""Tables as Markdown, and the claims and tables of a chapter as a part of a document."""

from __future__ import annotations

from collections.abc import Sequence

from auv_thesis.items import Table, Verdict
from auv_thesis.page.made import MadeChapter, MadeItem
from auv_thesis.page.wording import text_of


def chapter_markdown(made: MadeChapter) -> str:
    """Return the claims of a chapter, each with its verdict and evidence, and then its tables."""
    parts = [_claim(claim) for claim in made.claims] + [_table(table) for table in made.tables]
    return "\n".join(parts)


def markdown_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table with a heading; the text of a cell becomes one line."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(_cell(text) for text in line)} |" for line in lines) + "\n"


def _claim(made: MadeItem) -> str:
    if isinstance(made.content, Verdict):
        verdict = f"**{made.content.holds}.** {made.content.evidence}"
    else:
        verdict = f"**not judged.** {_failure(made)}"
    return f"{made.item.number}: {text_of(made.item)} {verdict}\n"


def _table(made: MadeItem) -> str:
    title = f"{made.item.number}: {text_of(made.item)}\n"
    if made.failure is not None:
        return f"{title}\n{_failure(made)}\n"
    beside = made.item.beside if isinstance(made.item, Table) else ""
    rows = [(row.quantity, row.thesis, row.ours, row.verdict, row.note) for row in made.rows]
    return f"{title}\n{markdown_table(('quantity', beside, 'ours', 'verdict', 'note'), rows)}"


def _failure(made: MadeItem) -> str:
    return f"Could not be made: {made.failure.line if made.failure is not None else 'no content'}"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
