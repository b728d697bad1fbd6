"""
Figures of a run, all from its recording.

A file ``figures/<name>.py`` in a folder of ``SHOAL_PLUGINS`` adds a figure of your own to the results of a
run. It is an `OwnFigure`: it draws one figure, and says what it is. docs/how_to/own_metrics.md
has an example.

Each figure is drawn in one of two styles of `auv_experiment.figures.plotting`: for a page and, where PDF or
SVG is asked for, for one column of a paper. Make a canvas with `new_canvas`: it has the width of the style.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

    from auv_experiment.recording import Recording
    from auv_experiment.scenario.schema import Scenario


@dataclass(frozen=True)
class Drawing:
    """A figure that is not on disk yet: what is drawn, its title, and what to see in it."""

    canvas: Canvas
    title: str
    caption: str


Drawer = Callable[[], Drawing | None]
"""Draws one figure, None where its data do not exist."""


class OwnFigure(Protocol):
    """The contract of a file with an own figure; the name of the file is that of the figure."""

    def draw(self, recording: Recording, scenario: Scenario) -> Drawing | None:
        """
        Draw the figure of a run.

        Parameters
        ----------
        recording : Recording
            What happened, as NumPy arrays.
        scenario : Scenario
            What was flown, resolved.

        Returns
        -------
        drawing : Drawing or None
            The figure; None where this run has no data for it.

        """
        ...
