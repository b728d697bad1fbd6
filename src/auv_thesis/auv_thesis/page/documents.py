"""
Writes equations.md from equations.yaml, and figures.md from the chapters, all of docs/reference.

Both are checked into the repository; a test fails if they are out of date.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from auv_core.machine.whole_files import write_text
from auv_thesis.items import Chapter, ChapterError, Item, RunSpec, function_of
from auv_thesis.page.equations import EQUATIONS_FILE, EquationList, load_equations
from auv_thesis.page.markdown import markdown_table

EQUATIONS_PAGE = "docs/reference/equations.md"
FIGURES_PAGE = "docs/reference/figures.md"
SHOWN_RUNS = 6

_GENERATED = "<!-- Written by `./scripts/reproduce --docs`; change {source} instead. -->\n"
_EQUATIONS_WORDS = """\
Every numbered equation of chapters 2 to 6: the function that implements it, the test that checks it, and
any difference from the print. The equations of chapter 1 are definitions from the literature.
"""
_FIGURES_WORDS = """\
The runs and the function of `src/auv_thesis/auv_thesis` that each item is made from.
`./scripts/reproduce` makes all of them. To fly one run, use `./scripts/run` with the arguments listed here.
"""


def write_documents(chapters: Sequence[Chapter], root: Path | None = None) -> list[Path]:
    """Write both pages into a checkout, by default the one that contains this file; return their files."""
    root = root or checkout()
    pages = documents(chapters, load_equations(root))
    for name, text in pages.items():
        write_text(root / name, text)
    return [root / name for name in pages]


def documents(chapters: Sequence[Chapter], listed: EquationList) -> dict[str, str]:
    """Return the text of both pages, by file."""
    return {EQUATIONS_PAGE: _equations_page(listed), FIGURES_PAGE: _figures_page(chapters)}


def checkout() -> Path:
    """Return the folder that holds docs/reference/equations.yaml; raise ChapterError if there is none."""
    for folder in Path(__file__).resolve().parents:
        if (folder / EQUATIONS_FILE).is_file():
            return folder
    raise ChapterError(f"{EQUATIONS_FILE} is not found; allowed: a command that runs in a checkout")


def _equations_page(listed: EquationList) -> str:
    parts = [
        "# Equations of the thesis\n",
        _GENERATED.format(source=EQUATIONS_FILE),
        _EQUATIONS_WORDS,
    ]
    for chapter in listed.counts:
        entries = [entry for entry in listed.implemented if entry.numbers[0][0] == chapter]
        if entries:
            parts.append(f"## Chapter {chapter}\n")
            rows = [
                (
                    _parenthesised(entry.equations),
                    entry.what,
                    "<br>".join(f"`{function}`" for function in entry.functions),
                    "<br>".join(f"`{_short(test)}`" for test in entry.tests),
                    entry.deviation or "none",
                )
                for entry in entries
            ]
            parts.append(markdown_table(("equation", "what", "function", "test", "deviation"), rows))
    parts.append("## Not implemented, and why\n")
    parts.append(
        markdown_table(
            ("equation", "what", "why"),
            [(_parenthesised(entry.equations), entry.what, entry.why) for entry in listed.left_out],
        )
    )
    return "\n".join(parts)


def _figures_page(chapters: Sequence[Chapter]) -> str:
    parts = [
        "# Figures, tables and claims of the thesis\n",
        _GENERATED.format(source="the chapters in src/auv_thesis/auv_thesis"),
        _FIGURES_WORDS,
    ]
    for chapter in chapters:
        parts.append(f"## {chapter.title}\n")
        for kind, items in (
            ("figure", chapter.figures),
            ("table", chapter.tables),
            ("claim", chapter.claims),
        ):
            rows = [(item.number, _words(item), _runs(item.runs), f"`{_function(item)}`") for item in items]
            if rows:
                parts.append(markdown_table((kind, "what", "runs", "function"), rows))
    return "\n".join(parts)


def _words(item: Item) -> str:
    return str(getattr(item, "title", "") or getattr(item, "text", ""))


def _runs(runs: Sequence[RunSpec]) -> str:
    distinct = list(dict.fromkeys(runs))
    shown = [f"`{spec}`" for spec in distinct[:SHOWN_RUNS]]
    if len(distinct) > SHOWN_RUNS:
        shown.append(f"and {len(distinct) - SHOWN_RUNS} more")
    return "<br>".join(shown)


def _function(item: Item) -> str:
    """Return the function of an item as module:name."""
    function = function_of(item)
    return f"{function.__module__.removeprefix('auv_thesis.')}:{_qualified_name(function)}"


def _qualified_name(function: Callable[..., Any]) -> str:
    """Return the name of a function; for one made by another function, the name of the latter."""
    return function.__qualname__.partition(".<locals>")[0]


def _parenthesised(equations: str) -> str:
    return re.sub(r"\d+\.\d+", lambda match: f"({match.group(0)})", equations)


def _short(test: str) -> str:
    """Return a test without the folders of its file."""
    return test.rpartition("/")[2]
