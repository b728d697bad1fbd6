"""The figures of a run: each family of laws has its own, and a group has those of a group."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from auv_experiment.recording import Recording
from auv_experiment.report.acoustics import acoustics_figures
from auv_experiment.report.figure import Figure
from auv_experiment.report.flock import draw_figures
from auv_experiment.report.path import path_figures
from auv_experiment.report.region import region_figures

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


def run_figures(recording: Recording, scenario: Scenario, out_dir: Path) -> list[Figure]:
    """Draw the figures of a run as PNG files into `out_dir`, in the order in which a report shows them."""
    if scenario.follows == "velocity":
        own = draw_figures(recording, scenario, out_dir)
    elif scenario.follows == "region":
        own = region_figures(recording, scenario, out_dir)
    else:
        own = path_figures(recording, scenario, out_dir)
        own += draw_figures(recording, scenario, out_dir, only=("pair_distances",))
    return own + acoustics_figures(recording, scenario, out_dir)
