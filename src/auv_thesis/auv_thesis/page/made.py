"""Make the content of the page from finished runs: draw figures, fill tables, judge claims."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

import matplotlib
from matplotlib.figure import Figure as Canvas
from matplotlib.gridspec import GridSpecBase

from auv_core.cli.tally import Tally
from auv_core.machine.failure import Failure
from auv_core.machine.workers import Advance, Call, attempt, spread
from auv_experiment.figures.formats import PAGE_FORMAT
from auv_experiment.figures.plotting import new_canvas, save_canvas, style_of, wrap_words
from auv_thesis.items import Chapter, Figure, Item, Row, Run, Table, Verdict, function_of

if TYPE_CHECKING:
    from auv_experiment.recording import Recording
    from auv_thesis.runs.runner import Flown
    from auv_thesis.runs.store import ResolvedRun, Store

HEIGHT_IN = 4.0
DPI = 130
_TWO_COLUMNS_IN = 7.16
_ROUNDING_IN = 0.05
_KEPT_RECORDINGS = 6

Content = dict[str, bytes] | tuple[Row, ...] | Verdict
"""A figure by the format of its file, PNG among them; a table's rows; a claim's verdict."""


@dataclass(frozen=True)
class MadeItem:
    """A figure, a table or a claim, and what was made of it."""

    item: Item
    content: Content | Failure

    @property
    def failure(self) -> Failure | None:
        """The reason why there is no content, None if there is content."""
        return self.content if isinstance(self.content, Failure) else None

    @property
    def rows(self) -> tuple[Row, ...]:
        """The rows of a table; empty for other items."""
        return self.content if isinstance(self.content, tuple) else ()


@dataclass(frozen=True)
class MadeChapter:
    """A chapter and its items as they were made, in the chapter's order."""

    chapter: Chapter
    figures: tuple[MadeItem, ...]
    tables: tuple[MadeItem, ...]
    claims: tuple[MadeItem, ...]

    @property
    def all(self) -> tuple[MadeItem, ...]:
        """Every item of the chapter."""
        return (*self.figures, *self.tables, *self.claims)


def evaluate(
    chapters: Sequence[Chapter],
    flown: Flown,
    store: Store,
    *,
    n_workers: int,
    tally: Tally,
    formats: Sequence[str] = (PAGE_FORMAT,),
) -> tuple[MadeChapter, ...]:
    """
    Make all figures, tables and claims of these chapters.

    An item fails if its function raises or one of its runs failed; the others are not affected.

    Parameters
    ----------
    chapters : sequence of Chapter
        The chapters to show.
    flown : Flown
        The results of the runs of these chapters.
    store : Store
        Where the finished runs are.
    n_workers : int
        Number of processes.
    tally : Tally
        Receives the failures.
    formats : sequence of str
        Formats of the figures; PNG is among them.

    """
    items = [item for chapter in chapters for item in chapter.items]
    contents: list[Content | Failure | None] = [_failure_of_runs(item, flown) for item in items]
    ready = [index for index, content in enumerate(contents) if content is None]
    tally.start(len(ready), float(len(ready)))

    groups = _together(items, ready)

    def call_of(index: int) -> Call:
        item = items[index]
        runs = tuple(flown.resolved[spec] for spec in item.runs)
        return partial(evaluate_item, item, runs, store, formats=formats)

    def note(place: int, made: list[Content | Failure] | Failure) -> None:
        group = groups[place]
        for index, content in zip(
            group, made if isinstance(made, list) else [made] * len(group), strict=True
        ):
            contents[index] = content
            if isinstance(content, Failure):
                tally.failed(name_of(items[index]), content)
            tally.finished()
        tally.advance(sum(content is not None for content in contents))

    spread(
        [partial(_evaluate, [call_of(index) for index in group]) for group in groups],
        n_workers,
        on_result=note,
        on_message=tally.message,
    )
    made = (
        MadeItem(item, content) for item, content in zip(items, contents, strict=True) if content is not None
    )
    return tuple(_made_chapter(chapter, made) for chapter in chapters)


def _made_chapter(chapter: Chapter, made: Iterator[MadeItem]) -> MadeChapter:
    """Return a chapter from the items of all chapters as they were made, in their order."""
    return MadeChapter(
        chapter,
        tuple(next(made) for _ in chapter.figures),
        tuple(next(made) for _ in chapter.tables),
        tuple(next(made) for _ in chapter.claims),
    )


def _together(items: Sequence[Item], ready: Sequence[int]) -> list[list[int]]:
    """
    Return the items that are ready, by index, in groups for one worker each.

    Items of one file that need no runs share a study. These groups come first, since a study takes longer
    than a drawing.
    """
    studies: dict[str, list[int]] = {}
    for index in ready:
        if not items[index].runs:
            studies.setdefault(function_of(items[index]).__module__, []).append(index)
    return [*studies.values(), *([index] for index in ready if items[index].runs)]


def _evaluate(calls: Sequence[Call], advance: Advance) -> list[Any]:
    return [attempt(call, advance) for call in calls]


def name_of(item: Item) -> str:
    """Return the name of an item, such as 'figure 2.6'."""
    kind = "figure" if isinstance(item, Figure) else "table" if isinstance(item, Table) else "claim"
    return f"{kind} {item.number}"


def evaluate_item(
    item: Item,
    resolved: Sequence[ResolvedRun],
    store: Store,
    advance: Advance = lambda amount: None,
    *,
    formats: Sequence[str] = (PAGE_FORMAT,),
) -> Content:
    """Make one item from its finished runs."""
    del advance
    runs: list[Run] = [_KeptRun(run, store) for run in resolved]
    if isinstance(item, Figure):
        return {file_format: _image(item, runs, file_format) for file_format in formats}
    if isinstance(item, Table):
        rows = tuple(item.rows(runs))
        if not all(isinstance(row, Row) for row in rows):
            raise TypeError(f"{name_of(item)}: its function must return rows")
        return rows
    verdict = item.judge(runs)
    if not isinstance(verdict, Verdict):
        raise TypeError(f"{name_of(item)}: its function must return a verdict")
    return verdict


class _KeptRun(Run):
    """
    A run from the store; its recording is read at use, since many tables need metrics only.

    Only the last few recordings stay in memory: hundreds of a study would not fit.
    """

    def __init__(self, resolved: ResolvedRun, store: Store) -> None:
        for name, value in (
            ("spec", resolved.spec),
            ("scenario", resolved.scenario),
            ("metrics", store.metrics(resolved.key)),
            ("_read", partial(_recording, store, resolved.key)),
        ):
            object.__setattr__(self, name, value)

    @property
    def recording(self) -> Recording:
        """The recording of the run."""
        recording: Recording = self.__dict__["_read"]()
        return recording


def _failure_of_runs(item: Item, flown: Flown) -> Failure | None:
    for spec in item.runs:
        if spec in flown.failed:
            return Failure(f"the run {spec} failed: {flown.failed[spec].line}", "")
    return None


@lru_cache(maxsize=_KEPT_RECORDINGS)
def _recording(store: Store, key: str) -> Recording:
    return store.recording(key)


def _image(figure: Figure, runs: list[Run], file_format: str) -> bytes:
    stream = io.BytesIO()
    with matplotlib.rc_context(style_of(file_format)):
        canvas = new_canvas(HEIGHT_IN)
        figure.draw(canvas, runs)
        if file_format != PAGE_FORMAT:
            _fit_to_paper(canvas)
        save_canvas(canvas, stream, file_format, dpi=DPI)
    return stream.getvalue()


def _fit_to_paper(canvas: Canvas) -> None:
    """Give a figure the width of one column of a paper; of two, if its panels or its words need them."""
    column_in = matplotlib.rcParams["figure.figsize"][0]
    if canvas.get_figwidth() > column_in:
        canvas.set_size_inches(column_in, 0.8 * canvas.get_figheight())
    grids = [axes.get_gridspec() for axes in canvas.axes]
    if any(isinstance(grid, GridSpecBase) and grid.ncols > 1 for grid in grids):
        canvas.set_figwidth(_TWO_COLUMNS_IN)
    wrap_words(canvas)
    box = canvas.get_tightbbox()
    if box.x0 < -_ROUNDING_IN or box.x1 > canvas.get_figwidth() + _ROUNDING_IN:
        canvas.set_figwidth(_TWO_COLUMNS_IN)
