"""
The items of the reproduction: figures, tables and claims, each made from our own runs.

A chapter is a folder of this package, or a file of a folder that several share. Its files define

    TITLE    heading on the page (the thesis's chapters have one already)
    FIGURES  tuple of `Figure`: a figure of the thesis and the function that draws it again
    TABLES   tuple of `Table`: a table of the thesis and the function that fills it again
    CLAIMS   tuple of `Claim`: a sentence of the thesis and the function that judges it

To add a figure, a table or a claim, append it to the tuple of its file. To add a chapter, write a file into
`laws`. The folders `ch2`, `ch3`, `formation`, `acoustics` and `torpedoes` are a chapter each. In `ch4_6` and
`laws` each file is a chapter of its name; a long chapter is split, such as `ch5` into `ch5.py` and
`ch5_claims.py`. An item that a file imports from another file of its chapter counts once.

1. A `RunSpec` names a run: a scenario and its changes. Equal ones are flown once.
2. The functions get the finished runs in the order of `runs`. They fly nothing and keep nothing.
3. Every number, verdict and piece of evidence comes from the runs; only what the thesis prints is typed in.
4. `draw` gets an empty Matplotlib figure in the style of `auv_experiment.figures.plotting`; the axes are the
   thesis's.
5. Studies of many seeds (`RunSpec.nth`) get the runs of the requested number of seeds only; their functions
   look at `run.spec`. A study that flies no scenario is a function with `functools.cache`: one worker makes
   all items of one file that name no runs, and computes it once.
6. Numbers ("2.6") are unique among figures, among tables and, with their text, among claims. Items that the
   thesis does not have take a letter: "3.A".

docs/how_to/reproduction.md explains how the page is made.
"""

from __future__ import annotations

import importlib
import re
import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import ModuleType
from typing import TYPE_CHECKING, Any

from auv_core.plugins import list_plugins

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

    from auv_experiment.recording import Recording
    from auv_experiment.scenario.schema import Scenario

AGREES, AGREES_IN_PART, DIFFERS, NO_NUMBER = "agrees", "agrees in part", "differs", "no number"
ROW_VERDICTS = (AGREES, AGREES_IN_PART, DIFFERS, NO_NUMBER)
HOLDS, HOLDS_IN_PART, DOES_NOT_HOLD = "holds", "holds in part", "does not hold"
CLAIM_VERDICTS = (HOLDS, HOLDS_IN_PART, DOES_NOT_HOLD)

READING_ORDER = (
    "ch2",
    "ch3",
    "formation",
    "ch4",
    "ch5",
    "ch6",
    "path_laws",
    "separation_laws",
    "formation_laws",
    "group_flock_laws",
    "conclusions",
    "acoustics",
    "envelope",
    "torpedoes",
)
_TITLES = {
    "ch2": "Chapter 2: path following of one vehicle",
    "ch3": "Chapter 3: adaptive formation",
    "ch4": "Chapter 4: steering to a safe region",
    "ch5": "Chapter 5: flocking with mathematical potentials",
    "ch6": "Chapter 6: flocking with fuzzy potentials",
    "path_laws": "Path-following laws on one plant",
    "formation_laws": "Laws for a group in formation",
    "group_flock_laws": "Sliding mode, H-infinity and adaptive fuzzy laws for a flock",
    "separation_laws": "Separation laws in one flock",
    "conclusions": "Abstract and conclusions of the thesis",
    "acoustics": "Acoustic communication",
    "envelope": "Safety envelope of the flock on a modem",
    "torpedoes": "Torpedoes in lanes over acoustic links",
}
_FOLDERS = ("acoustics", "ch2", "ch3", "ch4_6", "formation", "laws", "torpedoes")
_SHARED_FOLDERS = ("ch4_6", "laws")
_SEVERAL_FILES = re.compile(r"(ch\d+)(?:_\w+)?\Z")


class ChapterError(ValueError):
    """Raised for an unknown chapter, or two items with one number; the message is one line."""


@dataclass(frozen=True)
class RunSpec:
    """
    A run in one process: a scenario, `--set` overrides ("path=value") and perhaps another duration (s).

    Hashable; equal ones are flown once. The scenario's own seed and sampling apply unless overridden. A
    study flies one case with many seeds. Its runs have a `nth`, and are flown only if more than `nth` seeds
    are requested. They keep metrics only if `keep_recording` is false (a recording takes megabytes).
    """

    scenario: str
    overrides: tuple[str, ...] = ()
    duration_s: float | None = None
    keep_recording: bool = True
    nth: int = 0

    def __str__(self) -> str:
        """Return the run as the arguments of `./scripts/run`."""
        words = [self.scenario]
        for override in self.overrides:
            words += ["--set", override]
        if self.duration_s is not None:
            words += ["--duration", f"{self.duration_s:g}"]
        return shlex.join(words)


@dataclass(frozen=True, eq=False)
class Run:
    """A finished run: its spec, the resolved scenario, the recording and the metrics."""

    spec: RunSpec
    scenario: Scenario
    recording: Recording
    metrics: dict[str, Any]


@dataclass(frozen=True)
class Figure:
    """
    A figure of the thesis, drawn again.

    `draw(canvas, runs)` fills an empty Matplotlib figure; `caption` describes the thesis's figure and ours.
    """

    number: str
    title: str
    runs: tuple[RunSpec, ...]
    draw: Callable[[Canvas, list[Run]], None]
    caption: str


@dataclass(frozen=True)
class Row:
    """One quantity of a table: what the thesis prints, what our runs give, and how the two compare."""

    quantity: str
    thesis: str
    ours: str
    verdict: str
    note: str = ""

    def __post_init__(self) -> None:
        """Refuse a verdict that the page does not know."""
        _check_word("verdict", self.verdict, ROW_VERDICTS)


@dataclass(frozen=True)
class Table:
    """
    A table of the thesis, or one of ours; `rows(runs)` fills it, `beside` is the heading above `Row.thesis`.
    """

    number: str
    title: str
    runs: tuple[RunSpec, ...]
    rows: Callable[[list[Run]], list[Row]]
    beside: str = "thesis"


@dataclass(frozen=True)
class Verdict:
    """The verdict on a claim, and the numbers behind it."""

    holds: str
    evidence: str

    def __post_init__(self) -> None:
        """Refuse a verdict that the page does not know."""
        _check_word("holds", self.holds, CLAIM_VERDICTS)


@dataclass(frozen=True)
class Claim:
    """
    A claim of the thesis in our words; `number` is its section or figure, `judge(runs)` gives the verdict.
    """

    number: str
    text: str
    runs: tuple[RunSpec, ...]
    judge: Callable[[list[Run]], Verdict]


Item = Figure | Table | Claim


def function_of(item: Item) -> Callable[..., Any]:
    """Return the function that makes an item; for a partial, the wrapped function."""
    function: Any = next(getattr(item, word) for word in ("draw", "rows", "judge") if hasattr(item, word))
    while isinstance(function, partial):
        function = function.func
    return function


@dataclass(frozen=True)
class Chapter:
    """All items that the files of one chapter define, in the order of the file names."""

    key: str
    title: str
    figures: tuple[Figure, ...]
    tables: tuple[Table, ...]
    claims: tuple[Claim, ...]

    @property
    def items(self) -> tuple[Item, ...]:
        """All items of the chapter."""
        return (*self.figures, *self.tables, *self.claims)

    @property
    def runs(self) -> tuple[RunSpec, ...]:
        """The runs that the chapter needs, each once, in the order of first use."""
        return tuple(dict.fromkeys(spec for item in self.items for spec in item.runs))


def chapters() -> tuple[Chapter, ...]:
    """
    Return every chapter of this package: those of `READING_ORDER` first, then the others by name.

    Raises
    ------
    ChapterError
        If two different figures, or two different tables, have one number.

    """
    names = [f"{folder}.{file}" for folder in _FOLDERS for file in list_plugins(f"{__package__}.{folder}")]
    return chapters_of({name: importlib.import_module(f"{__package__}.{name}") for name in names})


def chapters_of(modules: dict[str, ModuleType]) -> tuple[Chapter, ...]:
    """
    Return the chapters that the modules form, by folder and file; modules without items are left out.
    """
    grouped: dict[str, list[ModuleType]] = {}
    for name in sorted(modules):
        if any(hasattr(modules[name], word) for word in ("FIGURES", "TABLES", "CLAIMS")):
            grouped.setdefault(chapter_key(name), []).append(modules[name])
    order = {key: index for index, key in enumerate(READING_ORDER)}
    keys = sorted(grouped, key=lambda key: (order.get(key, len(order)), key))
    found = tuple(_chapter(key, grouped[key]) for key in keys)
    _check_numbers("figure", [figure.number for chapter in found for figure in chapter.figures])
    _check_numbers("table", [table.number for chapter in found for table in chapter.tables])
    return found


def choose(found: Sequence[Chapter], keys: Sequence[str]) -> tuple[Chapter, ...]:
    """
    Return the chapters with these keys in reading order, or all chapters if no keys are given.

    Raises
    ------
    ChapterError
        If a chapter does not exist.

    """
    known = [chapter.key for chapter in found]
    for key in keys:
        if key not in known:
            raise ChapterError(f"{key!r} is not allowed; allowed: {', '.join(known) or 'nothing yet'}")
    return tuple(chapter for chapter in found if not keys or chapter.key in keys)


def with_seeds(found: Sequence[Chapter], n_seeds: int) -> tuple[Chapter, ...]:
    """Return the chapters with the runs of the first `n_seeds` seeds of each study only."""

    def fewer(items: tuple[Any, ...]) -> tuple[Any, ...]:
        return tuple(
            replace(item, runs=tuple(spec for spec in item.runs if spec.nth < n_seeds)) for item in items
        )

    return tuple(
        replace(
            chapter,
            figures=fewer(chapter.figures),
            tables=fewer(chapter.tables),
            claims=fewer(chapter.claims),
        )
        for chapter in found
    )


def chapter_key(module_name: str) -> str:
    """
    Return the chapter of a file: `ch2` for `ch2.claims`, `ch5` for `ch4_6.ch5_claims`, else the file's name.
    """
    folder, _, file = module_name.rpartition(".")
    if folder and folder not in _SHARED_FOLDERS:
        return folder
    match = _SEVERAL_FILES.match(file)
    return match.group(1) if match else file


def _chapter(key: str, modules: list[ModuleType]) -> Chapter:
    titles = [str(module.TITLE) for module in modules if hasattr(module, "TITLE")]
    return Chapter(
        key,
        titles[0] if titles else _TITLES.get(key, key.replace("_", " ").capitalize()),
        _items(modules, "FIGURES", Figure),
        _items(modules, "TABLES", Table),
        _items(modules, "CLAIMS", Claim),
    )


def _items(modules: list[ModuleType], word: str, kind: type[Any]) -> tuple[Any, ...]:
    """Return the items of the modules' tuples of this name, each once."""
    items = [item for module in modules for item in getattr(module, word, ())]
    for item in items:
        if not isinstance(item, kind):
            names = ", ".join(module.__name__ for module in modules)
            raise ChapterError(f"{names}: {word} holds {item!r}; allowed: {kind.__name__}")
    return tuple(dict.fromkeys(items))


def _check_numbers(kind: str, numbers: list[str]) -> None:
    twice = sorted({number for number in numbers if numbers.count(number) > 1})
    if twice:
        raise ChapterError(f"{kind} {twice[0]} is defined twice; allowed: one of each number")


def _check_word(field: str, word: str, allowed: tuple[str, ...]) -> None:
    if word not in allowed:
        raise ValueError(f"{field}: {word!r} is not allowed; allowed: {', '.join(allowed)}")
