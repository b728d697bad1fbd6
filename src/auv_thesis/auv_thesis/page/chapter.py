"""A chapter of the page: its claims, tables and figures."""

from __future__ import annotations

import html
from collections.abc import Sequence

from auv_experiment.figures.formats import PAGE_FORMAT
from auv_experiment.report.html import embedded_png
from auv_thesis.items import Figure, Row, RunSpec, Table, Verdict
from auv_thesis.page.made import MadeChapter, MadeItem
from auv_thesis.page.wording import anchor, heading, mark, place_of, slug, text_of


def chapter_section(made: MadeChapter) -> str:
    """Return the section of a chapter."""
    parts = [
        f"<section id='{made.chapter.key}' class='chapter'>",
        f"<h2>{html.escape(made.chapter.title)}</h2>",
    ]
    if made.claims:
        parts.append("<h3>Claims</h3>")
        parts += [_claim(claim) for claim in made.claims]
    if made.tables:
        parts.append("<h3>Tables</h3>")
        parts += [_table(table) for table in made.tables]
    if made.figures:
        parts.append("<h3>Figures</h3>")
        parts += [_figure(figure) for figure in made.figures]
    return "\n".join([*parts, "</section>"])


def _claim(made: MadeItem) -> str:
    if isinstance(made.content, Verdict):
        verdict, evidence = mark(made.content.holds), html.escape(made.content.evidence)
        kind = slug(made.content.holds)
    else:
        verdict, evidence, kind = "<b>not judged</b>", _failure(made), "failure"
    return (
        f"<div class='claim {kind}' id='{anchor(made.item)}'>\n"
        f"<p><span class='number'>{place_of(made.item)}</span> "
        f"{html.escape(text_of(made.item))}</p>\n"
        f"<p>{verdict}. {evidence}</p>\n{_commands(made.item.runs)}</div>"
    )


def _table(made: MadeItem) -> str:
    item = made.item
    caption = f"<caption>{html.escape(heading(item))}</caption>"
    if made.failure is not None:
        body = f"<tr><td>{_failure(made)}</td></tr>"
    else:
        beside = html.escape(item.beside if isinstance(item, Table) else "thesis")
        head = "".join(
            f"<th scope='col'>{word}</th>" for word in ("quantity", beside, "ours", "verdict", "note")
        )
        body = "\n".join([f"<tr>{head}</tr>", *(_row(row) for row in made.rows)])
    table = f"<table>\n{caption}\n{body}\n</table>"
    return f"<div class='scroll' id='{anchor(item)}'>{table}</div>\n{_commands(item.runs)}"


def _row(row: Row) -> str:
    cells = "".join(f"<td class='number'>{html.escape(text)}</td>" for text in (row.thesis, row.ours))
    return (
        f"<tr class='{slug(row.verdict)}'><th scope='row'>{html.escape(row.quantity)}</th>{cells}"
        f"<td>{mark(row.verdict)}</td><td>{html.escape(row.note)}</td></tr>"
    )


def _figure(made: MadeItem) -> str:
    item = made.item
    caption = html.escape(item.caption) if isinstance(item, Figure) else ""
    words = heading(item)
    if isinstance(made.content, dict):
        image = embedded_png(made.content[PAGE_FORMAT], f"{words}, drawn from our runs")
    else:
        image = f"<p>{_failure(made)}</p>"
    return (
        f"<figure id='{anchor(item)}'>\n{image}\n<figcaption><strong>{html.escape(words)}.</strong> "
        f"{caption}\n{_commands(item.runs)}</figcaption>\n</figure>"
    )


def _failure(made: MadeItem) -> str:
    line = made.failure.line if made.failure is not None else "no content"
    return f"<strong>Could not be made:</strong> {html.escape(line)}"


def _commands(runs: Sequence[RunSpec]) -> str:
    """Return the runs behind an item, as commands that fly them one by one."""
    if not runs:
        return ""
    lines = html.escape("\n".join(f"./scripts/run {spec} --mode inprocess" for spec in dict.fromkeys(runs)))
    words = "the run behind it" if len(set(runs)) == 1 else f"the {len(set(runs))} runs behind it"
    return f"<details><summary>{words}</summary><pre>{lines}</pre></details>"
