"""The content of the page as JSON, without the images of its figures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from auv_experiment.figures.formats import PAGE_FORMAT
from auv_thesis.items import Claim, Figure, Table, Verdict
from auv_thesis.page.made import MadeChapter
from auv_thesis.page.overview import counts
from auv_thesis.page.wording import slug, text_of

if TYPE_CHECKING:
    from auv_thesis.page.making import Making

FIGURES_FOLDER = "figures"


def figure_file(figure: Figure, file_format: str = PAGE_FORMAT) -> str:
    """Return the name of a figure's file."""
    return f"figure_{slug(figure.number)}.{file_format}"


def summary_of(chapters: Sequence[MadeChapter], making: Making) -> dict[str, Any]:
    """Return the content of the page without the images of its figures."""
    return {
        "counts": counts(chapters),
        "chapters": {made.chapter.key: _chapter_summary(made) for made in chapters},
        "command": making.command,
        "versions": making.versions,
        "runs": [
            {"run": run.name, "wall_s": run.wall_s, "cpu_s": run.cpu_s, "remark": run.remark}
            for run in making.runs
        ],
    }


def _chapter_summary(made: MadeChapter) -> dict[str, Any]:
    summary: dict[str, Any] = {"title": made.chapter.title, "claims": [], "tables": [], "figures": []}
    for one in made.all:
        known: dict[str, Any] = {"number": one.item.number}
        known["text" if isinstance(one.item, Claim) else "title"] = text_of(one.item)
        if one.failure is not None:
            known["failure"] = one.failure.line
        if isinstance(one.content, Verdict):
            known.update(holds=one.content.holds, evidence=one.content.evidence)
        if isinstance(one.item, Table):
            known["rows"] = [vars(row) for row in one.rows]
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
