"""
Figures of a path-following run: tracks, position and velocity errors, forces.

Errors are reference minus actual in NED, each vehicle against its own path. Each figure over time has the
approach on the left and the rest of the run on the right, on its own scale.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D

from auv_core.models import frame_of
from auv_experiment.figures import Drawer, Drawing
from auv_experiment.figures.plotting import (
    legend_below,
    mark,
    new_canvas,
    plot_obstacle,
    plot_plan_line,
    plot_thinned,
    set_height,
    span_time,
    vehicle_style,
)
from auv_experiment.metrics import path as metrics_path
from auv_experiment.metrics.distances import flock_positions_ned_m
from auv_experiment.recording import FloatArray, Recording

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

APPROACH_S = 60.0
_NED = ("north", "east", "down")


def path_drawers(recording: Recording, scenario: Scenario) -> dict[str, Drawer]:
    """Return the drawing functions of a path-following run, by name."""
    if not metrics_path.path_followers(scenario) or not np.isfinite(recording.position_ned_m).any():
        return {}

    def drawn(draw: Callable[..., tuple[str, str]]) -> Drawing:
        canvas = new_canvas()
        return Drawing(canvas, *draw(canvas, recording, scenario))

    return {name: partial(drawn, draw) for name, draw in _DRAWERS.items()}


def _draw_plan(canvas: Canvas, recording: Recording, scenario: Scenario) -> tuple[str, str]:
    set_height(canvas, 6.0)
    axes = canvas.add_subplot()
    paths, _ = metrics_path.path_points_ned(recording, scenario)
    positions = flock_positions_ned_m(recording)
    for i in range(recording.n_vehicles):
        plot_plan_line(axes, paths[:, i], color="0.6", linewidth=3.0, alpha=0.5, zorder=1)
        plot_plan_line(axes, positions[:, i], zorder=4, **vehicle_style(i))
        mark(axes, recording.position_ned_m[0, i], i, is_filled=False)
        mark(axes, recording.position_ned_m[-1, i], i, is_filled=True)
    for obstacle in scenario.environment.obstacles:
        plot_obstacle(axes, obstacle)
    axes.margins(0.06)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("east (m)")
    axes.set_ylabel("north (m)")
    handles = [Line2D([], [], color="0.6", linewidth=3.0, alpha=0.5, label="path")]
    legend_below(canvas, [*handles, *_vehicle_handles(recording)])
    caption = (
        "Tracks seen from above, north up, over the paths that the vehicles should follow (wide and grey). "
        "Hollow marks are starts, full marks ends."
    )
    if scenario.environment.obstacles:
        caption += (
            " Crosses are obstacles; their force changes sign at the dashed circle, the safety distance."
        )
    return "Tracks and paths", caption


def _draw_position_errors(canvas: Canvas, recording: Recording, scenario: Scenario) -> tuple[str, str]:
    errors_m = metrics_path.position_error_ned_m(recording, scenario)
    _draw_components(canvas, recording, errors_m, "error (m)", _NED)
    largest = np.nanmax(np.linalg.norm(errors_m, axis=-1), initial=0.0)
    caption = (
        f"Path minus position, component by component; the largest distance is {largest:.2f} m. Left: the "
        f"first {APPROACH_S:g} s. Right: the rest, on its own scale."
    )
    return "Position errors", caption


def _draw_velocity_errors(canvas: Canvas, recording: Recording, scenario: Scenario) -> tuple[str, str]:
    errors_mps = metrics_path.velocity_error_ned_mps(recording, scenario)
    _draw_components(canvas, recording, errors_mps, "error (m/s)", _NED)
    caption = (
        f"Velocity of the path minus velocity over ground, in NED. Left: the first {APPROACH_S:g} s. Right: "
        "the rest, on its own scale."
    )
    return "Velocity errors", caption


def _draw_forces(canvas: Canvas, recording: Recording, scenario: Scenario) -> tuple[str, str]:
    forces_n = np.full((len(recording.t_s), recording.n_vehicles, 3), np.nan)
    forces_n[:-1] = recording.command[..., :3]
    is_flat = any(frame_of(v.model.params) == "flat" for v in scenario.vehicles)
    _draw_components(canvas, recording, forces_n, "(N)", ("X", "Y", "Z"))
    axes_of = "north, east and down, as for this plant" if is_flat else "along the hulls' axes"
    caption = f"Commanded forces, {axes_of}."
    return "Commanded forces", caption


def _draw_components(
    canvas: Canvas, recording: Recording, values: FloatArray, unit: str, names: tuple[str, str, str]
) -> None:
    """Draw (K + 1, N, 3) values: a row for each component that is not always zero, two columns of time."""
    shown = [axis for axis in range(3) if np.nanmax(np.abs(values[..., axis]), initial=0.0) > 0.0] or [0]
    t_s = recording.t_s
    windows = [t_s <= APPROACH_S]
    if t_s[-1] > 1.5 * APPROACH_S:
        windows.append(t_s >= APPROACH_S)
    set_height(canvas, 1.1 + 1.5 * len(shown))
    grid = canvas.subplots(
        len(shown), len(windows), sharex="col", squeeze=False, width_ratios=(2, 3)[: len(windows)]
    )
    for row, axis in enumerate(shown):
        for axes, window in zip(grid[row], windows, strict=True):
            _plot_vehicles(axes, t_s[window], values[window, :, axis])
        grid[row, 0].set_ylabel(f"{names[axis]} {unit}")
    for axes, window in zip(grid[-1], windows, strict=True):
        axes.set_xlabel("time (s)")
        span_time(axes, t_s[window])
    legend_below(canvas, _vehicle_handles(recording))


def _plot_vehicles(axes: Any, t_s: FloatArray, values: FloatArray) -> None:
    axes.axhline(0.0, color="0.6", linewidth=0.7, zorder=1)
    for i in range(values.shape[1]):
        if np.isfinite(values[:, i]).any():
            plot_thinned(axes, t_s, values[:, i], **vehicle_style(i))


def _vehicle_handles(recording: Recording) -> list[Line2D]:
    if recording.n_vehicles > 10:
        return []
    return [Line2D([], [], label=name, **vehicle_style(i)) for i, name in enumerate(recording.vehicle_ids)]


_DRAWERS = {
    "path_plan": _draw_plan,
    "path_position_errors": _draw_position_errors,
    "path_velocity_errors": _draw_velocity_errors,
    "path_forces": _draw_forces,
}
