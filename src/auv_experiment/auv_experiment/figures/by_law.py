"""The figures of a run: those of its family of laws, of the group, of the network, and own ones."""

from __future__ import annotations

from typing import TYPE_CHECKING

from auv_experiment.figures import Drawer
from auv_experiment.figures.acoustics import acoustics_drawers
from auv_experiment.figures.course import course_drawers
from auv_experiment.figures.flock import flock_drawers
from auv_experiment.figures.own import own_drawers
from auv_experiment.figures.path import path_drawers
from auv_experiment.figures.region import region_drawers
from auv_experiment.figures.thrusters import thruster_drawers
from auv_experiment.recording import Recording
from auv_experiment.team_runs import team_runs

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

_APART = ("pair_distances",)


def run_drawers(recording: Recording, scenario: Scenario) -> dict[str, Drawer]:
    """
    Return the drawing functions of a run, by name, in the order of the report.

    A figure that several teams have is that of the first of them; distances are those of all vehicles.
    """
    runs = team_runs(recording, scenario)
    found: dict[str, Drawer] = {}
    for run in runs:
        found |= {name: draw for name, draw in _of_team(*run).items() if name not in found}
    if len(runs) > 1:
        found |= flock_drawers(recording, scenario, only=_APART)
    found |= thruster_drawers(recording, scenario)
    found |= acoustics_drawers(recording)
    return found | own_drawers(recording, scenario, taken=found)


def _of_team(recording: Recording, scenario: Scenario) -> dict[str, Drawer]:
    if scenario.follows == "velocity":
        return flock_drawers(recording, scenario)
    if scenario.follows == "region":
        return region_drawers(recording, scenario)
    draws = course_drawers if scenario.follows == "course" else path_drawers
    return draws(recording, scenario) | flock_drawers(recording, scenario, only=_APART)
