"""A figure of a report: what it says, and how it is written to disk."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib
from matplotlib.figure import Figure as Canvas

from auv_experiment.figures.plotting import STYLE, save_canvas

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

DPI = 170
WIDTH_IN = 6.5
MAX_LINES = 10
_THESIS_FIGURES = {
    (scenario, name): number
    for scenario, tracks, pairs in (
        ("ch5_four_leaders", "5.5", "5.6"),
        ("ch5_one_leader", "5.7", "5.8"),
        ("ch5_obstacles", "5.9", "5.10"),
    )
    for name, number in (("plan", f"{tracks} (b)"), ("space", f"{tracks} (a)"), ("pair_distances", pairs))
}


@dataclass(frozen=True)
class Figure:
    """One figure on disk: where it is, what it is called, what to see in it."""

    path: Path
    title: str
    caption: str


@dataclass(frozen=True)
class Drawing:
    """A figure that is not on disk yet."""

    canvas: Canvas
    title: str
    caption: str


Drawer = Callable[[], Drawing | None]
"""Draws one figure, None where its data do not exist."""


def draw_in_style(draw: Drawer) -> Drawing | None:
    """Draw in the style of all figures."""
    with matplotlib.rc_context(STYLE):
        return draw()


def save_figures(drawers: Mapping[str, Drawer], scenario: Scenario, out_dir: Path) -> list[Figure]:
    """Draw, in the style of all figures, and write each drawing as ``<name>.png``."""
    out_dir.mkdir(parents=True, exist_ok=True)
    figures = []
    for name, draw in drawers.items():
        with matplotlib.rc_context(STYLE):
            drawing = draw()
            if drawing is None:
                continue
            path = out_dir / f"{name}.png"
            save_canvas(drawing.canvas, path, DPI)
        thesis_figure = _THESIS_FIGURES.get((scenario.name, name))
        title = drawing.title + (f" (thesis Fig. {thesis_figure})" if thesis_figure else "")
        figures.append(Figure(path, title, drawing.caption))
    return figures
