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

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


def run_drawers(recording: Recording, scenario: Scenario) -> dict[str, Drawer]:
    """Return the drawing functions of a run, by name, in the order of the report."""
    if scenario.follows == "velocity":
        found = flock_drawers(recording, scenario)
    elif scenario.follows == "region":
        found = region_drawers(recording, scenario)
    elif scenario.follows == "course":
        found = course_drawers(recording, scenario)
        found |= flock_drawers(recording, scenario, only=("pair_distances",))
    else:
        found = path_drawers(recording, scenario)
        found |= flock_drawers(recording, scenario, only=("pair_distances",))
    found |= thruster_drawers(recording, scenario)
    found |= acoustics_drawers(recording)
    return found | own_drawers(recording, scenario, taken=found)
