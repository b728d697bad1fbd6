"""The figures of a run: each family of laws has its own, and a group has those of a group."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from auv_experiment.figures.acoustics import acoustics_drawers
from auv_experiment.figures.files import Drawer, Figure, save_figures
from auv_experiment.figures.flock import flock_drawers
from auv_experiment.figures.path import path_drawers
from auv_experiment.figures.region import region_drawers
from auv_experiment.recording import Recording

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


def run_drawers(recording: Recording, scenario: Scenario) -> dict[str, Drawer]:
    """Return what draws each figure of a run, by name, in the order in which a report shows them."""
    if scenario.follows == "velocity":
        own = flock_drawers(recording, scenario)
    elif scenario.follows == "region":
        own = region_drawers(recording, scenario)
    else:
        own = path_drawers(recording, scenario)
        own |= flock_drawers(recording, scenario, only=("pair_distances",))
    return own | acoustics_drawers(recording)


def run_figures(recording: Recording, scenario: Scenario, out_dir: Path) -> list[Figure]:
    """Draw the figures of a run as PNG files into `out_dir`, in the order in which a report shows them."""
    return save_figures(run_drawers(recording, scenario), scenario, out_dir)
