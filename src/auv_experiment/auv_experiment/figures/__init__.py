"""
Figures of a run, all from its recording.

A file ``figures/<name>.py`` in a folder of ``SHOAL_PLUGINS`` adds a figure of your own to the results of a
run. It is an `OwnFigure`: it draws one figure, with title and caption. docs/how_to/own_metrics.md
has an example.

Each figure is drawn in one of two styles of `auv_experiment.figures.plotting`: for a page, and for PDF or
SVG for one column of a paper. Make a canvas with `new_canvas`: it has the width of the style.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

    from auv_experiment.recording import Recording
    from auv_experiment.scenario.schema import Scenario


@dataclass(frozen=True)
class Drawing:
    """A figure that is not on disk yet, with title and caption."""

    canvas: Canvas
    title: str
    caption: str


@dataclass(frozen=True)
class Figure:
    """A figure on disk: its PNG file, title and caption."""

    path: Path
    title: str
    caption: str


@dataclass(frozen=True)
class SavedFigures:
    """The figures of a run, and a line for each own figure that failed."""

    figures: tuple[Figure, ...] = ()
    failures: tuple[str, ...] = ()


Drawer = Callable[[], Drawing | None]
"""Draws one figure; returns None if its data do not exist."""


class OwnFigure(Protocol):
    """The contract of a file with an own figure; the name of the file is that of the figure."""

    def draw(self, recording: Recording, scenario: Scenario) -> Drawing | None:
        """
        Draw the figure of a run.

        Parameters
        ----------
        recording : Recording
            The recording of the run, as NumPy arrays that cannot be changed.
        scenario : Scenario
            The resolved scenario.

        Returns
        -------
        drawing : Drawing or None
            The figure; None if this run has no data for it.

        """
        ...
