"""Figures that users add: files of `auv_experiment.figures.OwnFigure`."""

from __future__ import annotations

from collections.abc import Collection
from functools import partial
from types import ModuleType
from typing import TYPE_CHECKING

from auv_core.params import ConfigError, shown
from auv_experiment.figures import Drawer, Drawing
from auv_experiment.own_files import failure_line, load_own_files, read_only

if TYPE_CHECKING:
    from auv_experiment.recording import Recording
    from auv_experiment.scenario.schema import Scenario


class OwnFigureError(ConfigError):
    """Raised if an own figure cannot be drawn for a run; the message is one line that names the file."""


def own_files_of_figures() -> dict[str, ModuleType]:
    """
    Return the files of own figures, by name.

    Raises
    ------
    ConfigError
        If a file is not an `OwnFigure`; one line.

    """
    files = load_own_files(__package__)
    for name, module in files.items():
        if not callable(getattr(module, "draw", None)):
            raise ConfigError(
                f"figures/{name}.py: draw is missing; allowed: a function of recording and scenario"
            )
    return files


def own_drawers(recording: Recording, scenario: Scenario, taken: Collection[str]) -> dict[str, Drawer]:
    """
    Return the drawing functions of the own figures of a run, by name.

    Parameters
    ----------
    recording, scenario
        The run.
    taken : collection of str
        Names of the other figures.

    Raises
    ------
    ConfigError
        If a name is taken; one line.

    """
    files = own_files_of_figures()
    for name in files:
        if name in taken:
            raise ConfigError(f"figures/{name}.py: the name is that of another figure; allowed: another name")
    return {name: partial(_drawn, module, recording, scenario) for name, module in files.items()}


def _drawn(module: ModuleType, recording: Recording, scenario: Scenario) -> Drawing | None:
    """Draw an own figure; raise OwnFigureError if it fails."""
    try:
        drawing = module.draw(read_only(recording), scenario)
        if drawing is not None and not isinstance(drawing, Drawing):
            raise TypeError(f"draw returned {shown(drawing)}; allowed: a Drawing or None")
    except Exception as error:
        raise OwnFigureError(failure_line(module, error)) from error
    return drawing
