"""
The page of the reproduction: one self-contained HTML file, and its content as JSON.

Figures are embedded and styles are inline. There are no scripts, and nothing is fetched from the network.
Verdicts are shown by words and signs as well as by shade, so that the page prints in grey. All text from
chapters, scenarios or data is escaped.
"""

from __future__ import annotations

import html
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from auv_core.machine.whole_files import write_bytes, write_text
from auv_experiment.figures.formats import FORMATS
from auv_experiment.report.html import head, pairs_table
from auv_thesis.items import Figure
from auv_thesis.page.chapter import chapter_section
from auv_thesis.page.made import MadeChapter
from auv_thesis.page.markdown import chapter_markdown
from auv_thesis.page.overview import all_claims, contents, counts_table, failures
from auv_thesis.page.summary import FIGURES_FOLDER, figure_file, summary_of
from auv_thesis.page.template import PAGE

if TYPE_CHECKING:
    from auv_thesis.page.making import Making

PAGE_FILE = "index.html"
SUMMARY_FILE = "summary.json"
MARKDOWN_FOLDER = "chapters"

_TITLE = "The thesis, redone"


def write_page(folder: Path, chapters: Sequence[MadeChapter], making: Making) -> Path:
    """
    Write index.html, summary.json, figures/* and chapters/*.

    Parameters
    ----------
    folder : Path
        Folder of the page; made if it does not exist.
    chapters : sequence of MadeChapter
        The chapters to show, in this order.
    making : Making
        How it was made: command, versions, runs.

    Returns
    -------
    path : Path
        The page.

    """
    folder.mkdir(parents=True, exist_ok=True)
    _write_figures(folder / FIGURES_FOLDER, chapters)
    _write_markdown(folder / MARKDOWN_FOLDER, chapters)
    summary = summary_of(chapters, making)
    text = json.dumps(summary, indent=2, allow_nan=False, ensure_ascii=False)
    write_text(folder / SUMMARY_FILE, text + "\n")
    path = folder / PAGE_FILE
    write_text(path, page_html(chapters, making))
    return path


def page_html(chapters: Sequence[MadeChapter], making: Making) -> str:
    """Return the page as HTML."""
    return PAGE.substitute(
        head=head(_TITLE),
        title=_TITLE,
        facts=html.escape(making.facts),
        failures=failures(chapters),
        counts=counts_table(chapters),
        contents="\n".join(contents(chapters)),
        claims=all_claims(chapters),
        chapters="\n".join(chapter_section(chapter) for chapter in chapters),
        command=html.escape(making.command),
        versions=pairs_table(making.versions),
        runs=_runs_table(making),
    )


def _write_figures(folder: Path, chapters: Sequence[MadeChapter]) -> None:
    folder.mkdir(exist_ok=True)
    for file_format in FORMATS:
        for path in folder.glob(
            f"figure_*.{file_format}"
        ):  # left by an earlier call, perhaps for other chapters
            path.unlink()
    for chapter in chapters:
        for made in chapter.figures:
            if isinstance(made.item, Figure) and isinstance(made.content, dict):
                for file_format, data in made.content.items():
                    write_bytes(folder / figure_file(made.item, file_format), data)


def _write_markdown(folder: Path, chapters: Sequence[MadeChapter]) -> None:
    folder.mkdir(exist_ok=True)
    for path in folder.glob("*.md"):
        path.unlink()
    for made in chapters:
        write_text(folder / f"{made.chapter.key}.md", chapter_markdown(made))


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
