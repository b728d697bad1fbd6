"""A chapter of the page: its claims, tables and figures."""

from __future__ import annotations

import html
from collections.abc import Sequence

from auv_experiment.figures.formats import PAGE_FORMAT
from auv_experiment.report.html import embedded_png
from auv_thesis.items import Figure, Row, RunSpec, Table, Verdict
from auv_thesis.page.outcome import ChapterOutcome, Outcome
from auv_thesis.page.wording import anchor, heading, mark, place_of, slug, text_of


def chapter_section(outcome: ChapterOutcome) -> str:
    """Return the section of a chapter."""
    parts = [
        f"<section id='{outcome.chapter.key}' class='chapter'>",
        f"<h2>{html.escape(outcome.chapter.title)}</h2>",
    ]
    if outcome.claims:
        parts.append("<h3>Claims</h3>")
        parts += [_claim(claim) for claim in outcome.claims]
    if outcome.tables:
        parts.append("<h3>Tables</h3>")
        parts += [_table(table) for table in outcome.tables]
    if outcome.figures:
        parts.append("<h3>Figures</h3>")
        parts += [_figure(figure) for figure in outcome.figures]
    return "\n".join([*parts, "</section>"])


def _claim(outcome: Outcome) -> str:
    if isinstance(outcome.content, Verdict):
        verdict, evidence = mark(outcome.content.holds), html.escape(outcome.content.evidence)
        kind = slug(outcome.content.holds)
    else:
        verdict, evidence, kind = "<b>not judged</b>", _failure(outcome), "failure"
    return (
        f"<div class='claim {kind}' id='{anchor(outcome.item)}'>\n"
        f"<p><span class='number'>{place_of(outcome.item)}</span> "
        f"{html.escape(text_of(outcome.item))}</p>\n"
        f"<p>{verdict}. {evidence}</p>\n{_commands(outcome.item.runs)}</div>"
    )


def _table(outcome: Outcome) -> str:
    item = outcome.item
    caption = f"<caption>{html.escape(heading(item))}</caption>"
    if outcome.failure is not None:
        body = f"<tr><td>{_failure(outcome)}</td></tr>"
    else:
        beside = html.escape(item.beside if isinstance(item, Table) else "thesis")
        head = "".join(
            f"<th scope='col'>{word}</th>" for word in ("quantity", beside, "ours", "verdict", "note")
        )
        body = "\n".join([f"<tr>{head}</tr>", *(_row(row) for row in outcome.rows)])
    table = f"<table>\n{caption}\n{body}\n</table>"
    return f"<div class='scroll' id='{anchor(item)}'>{table}</div>\n{_commands(item.runs)}"


def _row(row: Row) -> str:
    cells = "".join(f"<td class='number'>{html.escape(text)}</td>" for text in (row.thesis, row.ours))
    return (
        f"<tr class='{slug(row.verdict)}'><th scope='row'>{html.escape(row.quantity)}</th>{cells}"
        f"<td>{mark(row.verdict)}</td><td>{html.escape(row.note)}</td></tr>"
    )


def _figure(outcome: Outcome) -> str:
    item = outcome.item
    caption = html.escape(item.caption) if isinstance(item, Figure) else ""
    words = heading(item)
    if isinstance(outcome.content, dict):
        image = embedded_png(outcome.content[PAGE_FORMAT], f"{words}, drawn from our runs")
    else:
        image = f"<p>{_failure(outcome)}</p>"
    return (
        f"<figure id='{anchor(item)}'>\n{image}\n<figcaption><strong>{html.escape(words)}.</strong> "
        f"{caption}\n{_commands(item.runs)}</figcaption>\n</figure>"
    )


def _failure(outcome: Outcome) -> str:
    line = outcome.failure.line if outcome.failure is not None else "no content"
    return f"<strong>Could not be made:</strong> {html.escape(line)}"


def _commands(runs: Sequence[RunSpec]) -> str:
    """Return the runs behind an item, as commands that fly them one by one."""
    if not runs:
        return ""
    lines = html.escape("\n".join(f"./scripts/run {spec} --mode inprocess" for spec in dict.fromkeys(runs)))
    words = "the run behind it" if len(set(runs)) == 1 else f"the {len(set(runs))} runs behind it"
    return f"<details><summary>{words}</summary><pre>{lines}</pre></details>"
