"""
Draw the figures of a flock's run from its recording.

Each `_draw_*` function of `flock_tracks`, `flock_histories` and `clearance` makes one figure from a
`FlockRun` and returns it with its title and caption, or None if the data do not exist. To add a figure, write
such a function and name it in the table at the end of its module. Plan views have north up and east to the
right; depth grows downwards. Vehicles differ in colour, line style and marker, so that the figures can be
read in grey. Long records are reduced to the smallest and the largest value of every pixel column, so that no
extreme is lost.
"""

from __future__ import annotations

from collections.abc import Collection
from functools import partial
from typing import TYPE_CHECKING

from auv_experiment.figures import Drawer
from auv_experiment.figures.clearance import CLEARANCE_DRAWERS
from auv_experiment.figures.flock_histories import HISTORY_DRAWERS
from auv_experiment.figures.flock_run import FlockRun
from auv_experiment.figures.flock_tracks import TRACK_DRAWERS
from auv_experiment.recording import Recording

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


def flock_drawers(
    recording: Recording, scenario: Scenario, *, only: Collection[str] | None = None
) -> dict[str, Drawer]:
    """Return the drawing functions of a group, by name."""
    run = FlockRun(recording, scenario)
    every = {**TRACK_DRAWERS, **HISTORY_DRAWERS, **CLEARANCE_DRAWERS}
    return {name: partial(draw, run) for name, draw in every.items() if only is None or name in only}
