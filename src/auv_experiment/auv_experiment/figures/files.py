"""Figures of a run as files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib import rc_context

from auv_core.machine.whole_files import whole_file
from auv_experiment.figures import Drawer, Drawing, Figure, SavedFigures
from auv_experiment.figures.formats import PAGE_FORMAT
from auv_experiment.figures.own import OwnFigureError
from auv_experiment.figures.plotting import PAGE_STYLE, save_canvas, style_of, wrap_words

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

DPI = 170
_THESIS_FIGURES = {
    (scenario, name): number
    for scenario, tracks, pairs in (
        ("ch5_four_leaders", "5.5", "5.6"),
        ("ch5_one_leader", "5.7", "5.8"),
        ("ch5_obstacles", "5.9", "5.10"),
    )
    for name, number in (("plan", f"{tracks} (b)"), ("space", f"{tracks} (a)"), ("pair_distances", pairs))
}


def draw_in_style(draw: Drawer) -> Drawing | None:
    """Draw in the style of pages."""
    with rc_context(PAGE_STYLE):
        return draw()


def save_figures(
    drawers: Mapping[str, Drawer],
    scenario: Scenario,
    out_dir: Path,
    formats: Sequence[str] = (PAGE_FORMAT,),
) -> SavedFigures:
    """
    Draw figures and write them as ``<name>.<format>``.

    Parameters
    ----------
    drawers : mapping of str to Drawer
        Drawing functions by name.
    scenario : Scenario
        The scenario, for its name.
    out_dir : Path
        Folder for the files; made if it does not exist.
    formats : sequence of str
        Formats of the files; PNG is among them.

    """
    out_dir.mkdir(parents=True, exist_ok=True)
    figures, failures = [], []
    for name, draw in drawers.items():
        try:
            drawing = draw_files(draw, out_dir / name, formats)
        except OwnFigureError as error:
            failures.append(str(error))
            continue
        if drawing is not None:
            thesis_figure = _THESIS_FIGURES.get((scenario.name, name))
            title = drawing.title + (f" (thesis Fig. {thesis_figure})" if thesis_figure else "")
            figures.append(Figure(out_dir / f"{name}.{PAGE_FORMAT}", title, drawing.caption))
    return SavedFigures(tuple(figures), tuple(failures))


def draw_files(
    draw: Drawer, stem: Path, formats: Sequence[str] = (PAGE_FORMAT,), *, dpi: int = DPI
) -> Drawing | None:
    """
    Draw a figure in the style of each format, and write each file completely or not at all.

    Parameters
    ----------
    draw : Drawer
        Draws the figure.
    stem : Path
        Path of the files without the ending.
    formats : sequence of str
        Of `auv_experiment.figures.formats.FORMATS`.
    dpi : int
        Resolution of PNG (dots per inch).

    Returns
    -------
    drawing : Drawing or None
        The figure; None if its data, and so the file, do not exist.

    Raises
    ------
    WriteError
        If a file cannot be written.

    """
    drawing = None
    for file_format in formats:
        with rc_context(style_of(file_format)):
            drawing = draw()
            if drawing is None:
                return None
            if file_format != PAGE_FORMAT:
                wrap_words(drawing.canvas)
            with whole_file(stem.with_name(f"{stem.name}.{file_format}")) as unfinished:
                save_canvas(drawing.canvas, unfinished, file_format, dpi=dpi)
    return drawing
