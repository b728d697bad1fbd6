"""The top of the page: numbers of verdicts, failed items, contents, and all claims in short."""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Iterable, Sequence

from auv_thesis.items import CLAIM_VERDICTS, ROW_VERDICTS, Verdict
from auv_thesis.page.made import MadeChapter, name_of
from auv_thesis.page.wording import anchor, capital, mark, place_of, text_of


def counts(chapters: Sequence[MadeChapter]) -> dict[str, dict[str, int]]:
    """Return the numbers of claims and rows by verdict, of figures, and of failures."""
    all_made = [made for chapter in chapters for made in chapter.all]
    claims = Counter(made.content.holds for made in all_made if isinstance(made.content, Verdict))
    rows = Counter(row.verdict for made in all_made for row in made.rows)
    return {
        "claims": {word: claims[word] for word in CLAIM_VERDICTS},
        "rows": {word: rows[word] for word in ROW_VERDICTS},
        "figures": {"drawn": sum(isinstance(made.content, dict) for made in all_made)},
        "failures": {"failed": sum(made.failure is not None for made in all_made)},
    }


def failures(chapters: Sequence[MadeChapter]) -> str:
    """Return the section on items that could not be made, empty if there are none."""
    failed = [made for chapter in chapters for made in chapter.all if made.failure is not None]
    if not failed:
        return ""
    items = "\n".join(
        f"<li><a href='#{anchor(made.item)}'>{html.escape(capital(name_of(made.item)))}</a>: "
        f"{html.escape(made.failure.line)}</li>"
        for made in failed
        if made.failure is not None
    )
    return f"<section class='failure'><h2>Items that could not be made</h2><ul>\n{items}\n</ul></section>"


def counts_table(chapters: Sequence[MadeChapter]) -> str:
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


def contents(chapters: Sequence[MadeChapter]) -> Iterable[str]:
    """Yield a line with links for every chapter."""
    for chapter in chapters:
        parts = []
        for name, all_made in (("Tables", chapter.tables), ("Figures", chapter.figures)):
            links = ", ".join(
                f"<a href='#{anchor(made.item)}'>{html.escape(made.item.number)}</a>" for made in all_made
            )
            parts += [f"{name} {links}."] if links else []
        yield f"<li>{_link(chapter)}<br><small>{' '.join(parts)}</small></li>"


def all_claims(chapters: Sequence[MadeChapter]) -> str:
    """Return the claims of all chapters by verdict, each with a link to its evidence."""
    parts = []
    for word in CLAIM_VERDICTS:
        found = [
            made
            for chapter in chapters
            for made in chapter.claims
            if isinstance(made.content, Verdict) and made.content.holds == word
        ]
        if found:
            items = "\n".join(
                f"<li><a href='#{anchor(made.item)}'>{place_of(made.item)}</a>: "
                f"{html.escape(text_of(made.item))}</li>"
                for made in found
            )
            parts.append(f"<h3>{mark(word)} ({len(found)})</h3>\n<ul class='claims'>\n{items}\n</ul>")
    return "\n".join(parts)


def _link(chapter: MadeChapter) -> str:
    return f"<a href='#{chapter.chapter.key}'>{html.escape(chapter.chapter.title)}</a>"
