"""
The page of the reproduction: one HTML file that needs nothing else, and its content as JSON.

Figures are embedded, styles are inline, there is no script and no address to fetch from. Verdicts are told
by words and signs as well as by shade, so that it prints in grey. Everything that comes from a chapter, a
scenario or data is escaped.
"""

from __future__ import annotations

import html
import json
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from auv_core.machine.whole_files import write_bytes, write_text
from auv_experiment.report.html import embedded_png, head, pairs_table
from auv_thesis.items import (
    AGREES,
    AGREES_IN_PART,
    CLAIM_VERDICTS,
    DIFFERS,
    DOES_NOT_HOLD,
    HOLDS,
    HOLDS_IN_PART,
    NO_NUMBER,
    ROW_VERDICTS,
    Claim,
    Figure,
    Item,
    Row,
    RunSpec,
    Table,
    Verdict,
)
from auv_thesis.page.outcome import ChapterOutcome, Outcome, name_of
from auv_thesis.page.template import PAGE

if TYPE_CHECKING:
    from auv_thesis.page.making import Making

PAGE_FILE = "index.html"
SUMMARY_FILE = "summary.json"
FIGURES_FOLDER = "figures"

_TITLE = "The thesis, redone"
_SIGNS = {
    HOLDS: "●",
    HOLDS_IN_PART: "◐",
    DOES_NOT_HOLD: "○",
    AGREES: "●",
    AGREES_IN_PART: "◐",
    DIFFERS: "○",
    NO_NUMBER: "–",
}


def write_page(folder: Path, chapters: Sequence[ChapterOutcome], making: Making) -> Path:
    """
    Write index.html, summary.json and figures/*.png.

    Parameters
    ----------
    folder : Path
        Folder of the page; made if it does not exist.
    chapters : sequence of ChapterOutcome
        What is shown, in this order.
    making : Making
        How it was made: command, versions, runs.

    Returns
    -------
    path : Path
        The page.

    """
    folder.mkdir(parents=True, exist_ok=True)
    _write_figures(folder / FIGURES_FOLDER, chapters)
    summary = _summary(chapters, making)
    text = json.dumps(summary, indent=2, allow_nan=False, ensure_ascii=False)
    write_text(folder / SUMMARY_FILE, text + "\n")
    path = folder / PAGE_FILE
    write_text(path, page_html(chapters, making))
    return path


def page_html(chapters: Sequence[ChapterOutcome], making: Making) -> str:
    """Return the page as HTML."""
    return PAGE.substitute(
        head=head(_TITLE),
        title=_TITLE,
        facts=html.escape(making.facts),
        failures=_failures(chapters),
        counts=_counts_table(chapters),
        contents="\n".join(_contents(chapters)),
        claims=_all_claims(chapters),
        chapters="\n".join(_chapter(chapter) for chapter in chapters),
        command=html.escape(making.command),
        versions=pairs_table(making.versions),
        runs=_runs_table(making),
    )


def counts(chapters: Sequence[ChapterOutcome]) -> dict[str, dict[str, int]]:
    """Return how many claims and rows there are of each verdict, how many figures, how many failures."""
    outcomes = [outcome for chapter in chapters for outcome in chapter.all]
    claims = Counter(outcome.content.holds for outcome in outcomes if isinstance(outcome.content, Verdict))
    rows = Counter(row.verdict for outcome in outcomes for row in _rows(outcome))
    return {
        "claims": {word: claims[word] for word in CLAIM_VERDICTS},
        "rows": {word: rows[word] for word in ROW_VERDICTS},
        "figures": {"drawn": sum(isinstance(outcome.content, bytes) for outcome in outcomes)},
        "failures": {"failed": sum(outcome.failure is not None for outcome in outcomes)},
    }


def figure_file(figure: Figure) -> str:
    """Return the name of a figure's PNG file."""
    return f"figure_{_slug(figure.number)}.png"


def _write_figures(folder: Path, chapters: Sequence[ChapterOutcome]) -> None:
    folder.mkdir(exist_ok=True)
    for path in folder.glob("figure_*.png"):  # of an earlier call, perhaps of other chapters
        path.unlink()
    for chapter in chapters:
        for outcome in chapter.figures:
            if isinstance(outcome.item, Figure) and isinstance(outcome.content, bytes):
                write_bytes(folder / figure_file(outcome.item), outcome.content)


def _rows(outcome: Outcome) -> tuple[Row, ...]:
    return outcome.content if isinstance(outcome.content, tuple) else ()


def _failures(chapters: Sequence[ChapterOutcome]) -> str:
    failed = [outcome for chapter in chapters for outcome in chapter.all if outcome.failure is not None]
    if not failed:
        return ""
    items = "\n".join(
        f"<li><a href='#{_anchor(outcome.item)}'>{html.escape(_capital(name_of(outcome.item)))}</a>: "
        f"{html.escape(outcome.failure.line)}</li>"
        for outcome in failed
        if outcome.failure is not None
    )
    return f"<section class='failure'><h2>What could not be made</h2><ul>\n{items}\n</ul></section>"


def _counts_table(chapters: Sequence[ChapterOutcome]) -> str:
    found = counts(chapters)
    head = "".join(f"<th scope='col' class='value'>{_mark(word)}</th>" for word in CLAIM_VERDICTS)
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


def _contents(chapters: Sequence[ChapterOutcome]) -> Iterable[str]:
    for chapter in chapters:
        parts = []
        for name, outcomes in (("Tables", chapter.tables), ("Figures", chapter.figures)):
            links = ", ".join(
                f"<a href='#{_anchor(outcome.item)}'>{html.escape(outcome.item.number)}</a>"
                for outcome in outcomes
            )
            parts += [f"{name} {links}."] if links else []
        yield f"<li>{_link(chapter)}<br><small>{' '.join(parts)}</small></li>"


def _all_claims(chapters: Sequence[ChapterOutcome]) -> str:
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
                f"<li><a href='#{_anchor(outcome.item)}'>{_place(outcome.item)}</a>: "
                f"{html.escape(_text(outcome.item))}</li>"
                for outcome in found
            )
            parts.append(f"<h3>{_mark(word)} ({len(found)})</h3>\n<ul class='claims'>\n{items}\n</ul>")
    return "\n".join(parts)


def _chapter(outcome: ChapterOutcome) -> str:
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
        verdict, evidence = _mark(outcome.content.holds), html.escape(outcome.content.evidence)
        kind = _slug(outcome.content.holds)
    else:
        verdict, evidence, kind = "<b>not judged</b>", _failure(outcome), "failure"
    return (
        f"<div class='claim {kind}' id='{_anchor(outcome.item)}'>\n"
        f"<p><span class='number'>{_place(outcome.item)}</span> "
        f"{html.escape(_text(outcome.item))}</p>\n"
        f"<p>{verdict}. {evidence}</p>\n{_commands(outcome.item.runs)}</div>"
    )


def _table(outcome: Outcome) -> str:
    item = outcome.item
    caption = f"<caption>{html.escape(_heading(item))}</caption>"
    if outcome.failure is not None:
        body = f"<tr><td>{_failure(outcome)}</td></tr>"
    else:
        beside = html.escape(item.beside if isinstance(item, Table) else "thesis")
        head = "".join(
            f"<th scope='col'>{word}</th>" for word in ("quantity", beside, "ours", "verdict", "note")
        )
        body = "\n".join([f"<tr>{head}</tr>", *(_row(row) for row in _rows(outcome))])
    table = f"<table>\n{caption}\n{body}\n</table>"
    return f"<div class='scroll' id='{_anchor(item)}'>{table}</div>\n{_commands(item.runs)}"


def _row(row: Row) -> str:
    cells = "".join(f"<td class='number'>{html.escape(text)}</td>" for text in (row.thesis, row.ours))
    return (
        f"<tr class='{_slug(row.verdict)}'><th scope='row'>{html.escape(row.quantity)}</th>{cells}"
        f"<td>{_mark(row.verdict)}</td><td>{html.escape(row.note)}</td></tr>"
    )


def _figure(outcome: Outcome) -> str:
    item = outcome.item
    caption = html.escape(item.caption) if isinstance(item, Figure) else ""
    heading = html.escape(_heading(item))
    if isinstance(outcome.content, bytes):
        image = embedded_png(outcome.content, f"{_heading(item)}, drawn from our runs")
    else:
        image = f"<p>{_failure(outcome)}</p>"
    return (
        f"<figure id='{_anchor(item)}'>\n{image}\n<figcaption><strong>{heading}.</strong> {caption}\n"
        f"{_commands(item.runs)}</figcaption>\n</figure>"
    )


def _failure(outcome: Outcome) -> str:
    line = outcome.failure.line if outcome.failure is not None else "no content"
    return f"<strong>Could not be made:</strong> {html.escape(line)}"


def _commands(runs: Sequence[RunSpec]) -> str:
    """Give the runs behind an item, as commands that fly them one by one."""
    if not runs:
        return ""
    lines = html.escape("\n".join(f"./scripts/run {spec} --mode inprocess" for spec in dict.fromkeys(runs)))
    words = "the run behind it" if len(set(runs)) == 1 else f"the {len(set(runs))} runs behind it"
    return f"<details><summary>{words}</summary><pre>{lines}</pre></details>"


def _runs_table(making: Making) -> str:
    head = "".join(f"<th scope='col' class='value'>{word} (s)</th>" for word in ("wall", "processor"))
    rows = [f"<tr><th scope='col'>run</th>{head}<th scope='col'>remark</th></tr>"]
    for run in making.runs:
        times = ("" if time_s is None else f"{time_s:.1f}" for time_s in (run.wall_s, run.cpu_s))
        cells = "".join(f"<td class='value'>{text}</td>" for text in times)
        rows.append(
            f"<tr><td><code>{html.escape(run.name)}</code></td>{cells}<td>{html.escape(run.remark)}</td></tr>"
        )
    return f"<table>\n{chr(10).join(rows)}\n</table>"


def _mark(word: str) -> str:
    return f"<b class='mark'><span aria-hidden='true'>{_SIGNS[word]}</span> {word}</b>"


def _link(chapter: ChapterOutcome) -> str:
    return f"<a href='#{chapter.chapter.key}'>{html.escape(chapter.chapter.title)}</a>"


def _heading(item: Item) -> str:
    title = "" if isinstance(item, Claim) else f". {item.title}"
    return f"{_capital(name_of(item))}{title}"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _place(claim: Item) -> str:
    """Return where in the thesis a claim is; a bare number is a section's."""
    return html.escape(f"Section {claim.number}" if claim.number[:1].isdigit() else claim.number)


def _text(item: Item) -> str:
    return item.text if isinstance(item, Claim) else item.title


def _anchor(item: Item) -> str:
    """Return the anchor of an item; several claims may have one number, so that their text counts too."""
    if isinstance(item, Claim):
        return f"claim-{_slug(item.number)}-{_slug(item.text)[:60]}"
    return _slug(name_of(item))


def _slug(text: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")


def _summary(chapters: Sequence[ChapterOutcome], making: Making) -> dict[str, Any]:
    """Return what the page says, without its figures' images."""
    return {
        "counts": counts(chapters),
        "chapters": {outcome.chapter.key: _chapter_summary(outcome) for outcome in chapters},
        "command": making.command,
        "versions": making.versions,
        "runs": [
            {"run": run.name, "wall_s": run.wall_s, "cpu_s": run.cpu_s, "remark": run.remark}
            for run in making.runs
        ],
    }


def _chapter_summary(outcome: ChapterOutcome) -> dict[str, Any]:
    summary: dict[str, Any] = {"title": outcome.chapter.title, "claims": [], "tables": [], "figures": []}
    for one in outcome.all:
        known: dict[str, Any] = {"number": one.item.number}
        known["text" if isinstance(one.item, Claim) else "title"] = _text(one.item)
        if one.failure is not None:
            known["failure"] = one.failure.line
        if isinstance(one.content, Verdict):
            known.update(holds=one.content.holds, evidence=one.content.evidence)
        if isinstance(one.item, Table):
            known["rows"] = [vars(row) for row in _rows(one)]
        if isinstance(one.item, Figure):
            known["file"] = f"{FIGURES_FOLDER}/{figure_file(one.item)}" if one.failure is None else None
        kind = (
            "claims"
            if isinstance(one.item, Claim)
            else "tables"
            if isinstance(one.item, Table)
            else "figures"
        )
        summary[kind].append(known)
    return summary
