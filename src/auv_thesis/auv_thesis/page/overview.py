"""The top of the page: numbers of verdicts, failed items, contents, and all claims in short."""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Iterable, Sequence

from auv_thesis.items import CLAIM_VERDICTS, ROW_VERDICTS, Verdict
from auv_thesis.page.outcome import ChapterOutcome, name_of
from auv_thesis.page.wording import anchor, capital, mark, place_of, text_of


def counts(chapters: Sequence[ChapterOutcome]) -> dict[str, dict[str, int]]:
    """Return the numbers of claims and rows by verdict, of figures, and of failures."""
    outcomes = [outcome for chapter in chapters for outcome in chapter.all]
    claims = Counter(outcome.content.holds for outcome in outcomes if isinstance(outcome.content, Verdict))
    rows = Counter(row.verdict for outcome in outcomes for row in outcome.rows)
    return {
        "claims": {word: claims[word] for word in CLAIM_VERDICTS},
        "rows": {word: rows[word] for word in ROW_VERDICTS},
        "figures": {"drawn": sum(isinstance(outcome.content, dict) for outcome in outcomes)},
        "failures": {"failed": sum(outcome.failure is not None for outcome in outcomes)},
    }


def failures(chapters: Sequence[ChapterOutcome]) -> str:
    """Return the section on items that could not be made, empty if there are none."""
    failed = [outcome for chapter in chapters for outcome in chapter.all if outcome.failure is not None]
    if not failed:
        return ""
    items = "\n".join(
        f"<li><a href='#{anchor(outcome.item)}'>{html.escape(capital(name_of(outcome.item)))}</a>: "
        f"{html.escape(outcome.failure.line)}</li>"
        for outcome in failed
        if outcome.failure is not None
    )
    return f"<section class='failure'><h2>Items that could not be made</h2><ul>\n{items}\n</ul></section>"


def counts_table(chapters: Sequence[ChapterOutcome]) -> str:
    """Return the table of verdicts and figures by chapter."""
    found = counts(chapters)
    head = "".join(f"<th scope='col' class='value'>{mark(word)}</th>" for word in CLAIM_VERDICTS)
    rows = [f"<tr><th scope='col'>chapter</th>{head}<th scope='col' class='value'>figures</th></tr>"]
    for chapter in chapters:
        own = counts([chapter])
        rows.append(_counts_row(_link(chapter), own))
    if len(chapters) > 1:
        rows.append(_counts_row("<b>together</b>", found))
    table_rows = ", ".join(f"{n} {word}" for word, n in found["rows"].items() if n)
    note = f"<p>Rows of tables: {html.escape(table_rows)}.</p>" if table_rows else ""
    return f"<div class='scroll'><table class='counts'>\n{chr(10).join(rows)}\n</table></div>\n{note}"


def _counts_row(name: str, found: dict[str, dict[str, int]]) -> str:
    cells = "".join(f"<td class='value'>{found['claims'][word]}</td>" for word in CLAIM_VERDICTS)
    return f"<tr><td>{name}</td>{cells}<td class='value'>{found['figures']['drawn']}</td></tr>"


def contents(chapters: Sequence[ChapterOutcome]) -> Iterable[str]:
    """Yield a line with links for every chapter."""
    for chapter in chapters:
        parts = []
        for name, outcomes in (("Tables", chapter.tables), ("Figures", chapter.figures)):
            links = ", ".join(
                f"<a href='#{anchor(outcome.item)}'>{html.escape(outcome.item.number)}</a>"
                for outcome in outcomes
            )
            parts += [f"{name} {links}."] if links else []
        yield f"<li>{_link(chapter)}<br><small>{' '.join(parts)}</small></li>"


def all_claims(chapters: Sequence[ChapterOutcome]) -> str:
    """Return the claims of all chapters by verdict, each with a link to its evidence."""
    parts = []
    for word in CLAIM_VERDICTS:
        found = [
            outcome
            for chapter in chapters
            for outcome in chapter.claims
            if isinstance(outcome.content, Verdict) and outcome.content.holds == word
        ]
        if found:
            items = "\n".join(
                f"<li><a href='#{anchor(outcome.item)}'>{place_of(outcome.item)}</a>: "
                f"{html.escape(text_of(outcome.item))}</li>"
                for outcome in found
            )
            parts.append(f"<h3>{mark(word)} ({len(found)})</h3>\n<ul class='claims'>\n{items}\n</ul>")
    return "\n".join(parts)


def _link(chapter: ChapterOutcome) -> str:
    return f"<a href='#{chapter.chapter.key}'>{html.escape(chapter.chapter.title)}</a>"
