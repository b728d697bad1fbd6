"""The figure of the thrusters of a run: the force of each over time, one panel for each vehicle."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from matplotlib.lines import Line2D

from auv_core.models import thrusters_of
from auv_experiment.figures import Drawer, Drawing
from auv_experiment.figures.plotting import (
    colour,
    legend_below,
    new_canvas,
    plot_thinned,
    span_time,
)
from auv_experiment.recording import Recording

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

_MOST_VEHICLES = 4
_SOLID = 6
"""Number of colours; further thrusters have them again, dashed."""


def thruster_drawers(recording: Recording, scenario: Scenario) -> dict[str, Drawer]:
    """Return the drawing function of a run in which a vehicle has thrusters, by name."""
    shown = [i for i, vehicle in enumerate(scenario.vehicles) if thrusters_of(vehicle.model).count]
    if not shown or recording.n_ticks == 0:
        return {}
    shown.sort(key=lambda i: scenario.vehicles[i].fault.thruster == 0)
    return {"thrusters": partial(_draw, recording, scenario, sorted(shown[:_MOST_VEHICLES]))}


def _draw(recording: Recording, scenario: Scenario, shown: list[int]) -> Drawing:
    canvas = new_canvas(1.1 + 1.5 * len(shown))
    grid = canvas.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
    most = 0
    for axes, i in zip(grid, shown, strict=True):
        vehicle = scenario.vehicles[i]
        count = thrusters_of(vehicle.model).count
        most = max(most, count)
        for k in range(count):
            plot_thinned(
                axes, recording.t_s, recording.actuator_output[:, i, k], color=colour(k), linestyle=_dashes(k)
            )
        if vehicle.fault.has_begun(recording.t_s[-1]):
            axes.axvline(vehicle.fault.t_s, color="0.4", linestyle=":")
        axes.set_ylabel(f"{vehicle.id} (N)")
    grid[-1].set_xlabel("time (s)")
    span_time(grid[-1], recording.t_s)
    handles = [Line2D([], [], color=colour(k), linestyle=_dashes(k)) for k in range(most)]
    legend_below(canvas, handles, [str(k + 1) for k in range(most)])
    caption = "Force of each thruster along its own direction. A dotted line is the time at which one fails."
    return Drawing(canvas, "Thrusters", caption)


def _dashes(k: int) -> str:
    return "-" if k < _SOLID else "--"
