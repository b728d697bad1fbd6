"""Figures of a flock's tracks: from above, and in space."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from auv_experiment.figures import Drawing
from auv_experiment.figures.flock_run import FlockRun, path_handle, vehicle_handles
from auv_experiment.figures.hulls import plot_hulls
from auv_experiment.figures.plotting import (
    MAX_COLUMNS,
    colour,
    equal_box,
    legend_below,
    mark,
    marker,
    new_canvas,
    plot_obstacle,
    plot_plan_line,
    plot_sphere,
    round_ticks,
    space_axes,
    vehicle_style,
)
from auv_experiment.metrics.distances import obstacle_positions_ned_m
from auv_experiment.recording import FloatArray


def _draw_plan(run: FlockRun) -> Drawing | None:
    if not np.isfinite(run.recording.position_ned_m).any():
        return None
    canvas = new_canvas(6.2)
    axes = canvas.add_subplot()
    plot_plan_line(axes, run.path_ned_m, color="0.55", linewidth=3.0, alpha=0.55, zorder=1)
    plot_plan_line(axes, run.centroid_ned_m, color="0.35", linewidth=1.4, linestyle=(0, (2, 1)), zorder=3)
    for i in range(run.recording.n_vehicles):
        style = vehicle_style(i)
        track = run.recording.position_ned_m[:, i]
        plot_plan_line(axes, run.flock_ned_m[:, i], linewidth=0.9, zorder=4, **style)
        plot_plan_line(axes, _only_lost(run, i), color=style["color"], linewidth=0.5, alpha=0.5, zorder=4)
        mark(axes, track[0], i, is_filled=False)
        mark(axes, track[-1], i, is_filled=True)
    _plot_obstacles(axes, run)
    instants = round_ticks(run.t_s)
    for k in instants:
        _plot_hulls(axes, run, k)
    axes.margins(0.06)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("east (m)")
    axes.set_ylabel("north (m)")
    legend_below(canvas, _plan_legend(run))
    times = ", ".join(f"{run.t_s[k]:.0f}" for k in instants)
    caption = (
        "Tracks seen from above, north up. The wide grey line is the path that the flock should follow, the "
        "dashed grey line the mean of the vehicles. Hollow marks are starts, full marks are ends; between "
        f"them are the hulls to scale with their heading, at {times} s."
    )
    if run.scenario.environment.obstacles:
        caption += (
            " Crosses are obstacles, each with the distance at which its repulsion begins; a track that "
            "crosses such a circle may also pass above or below."
        )
    if any(obstacle.is_moving for obstacle in run.scenario.environment.obstacles):
        caption += " A moving obstacle is marked where it was at 0 s; the dotted line is its track."
    return Drawing(canvas, "Tracks in the plane", caption)


def _draw_space(run: FlockRun) -> Drawing | None:
    positions = run.recording.position_ned_m
    if not np.isfinite(positions).any():
        return None
    canvas = new_canvas(5.2, layout=None)
    axes = space_axes(canvas)
    north, east, down = run.path_ned_m.T
    axes.plot(east, north, down, color="0.55", linewidth=3.0, alpha=0.55)
    every = max(1, run.recording.n_ticks // (2 * MAX_COLUMNS))
    for i in range(run.recording.n_vehicles):
        north, east, down = run.flock_ned_m[::every, i].T
        axes.plot(east, north, down, linewidth=0.9, **vehicle_style(i))
        for k, fill in ((0, "white"), (-1, colour(i))):
            north, east, down = positions[k, i]
            axes.plot([east], [north], [down], marker(i), color=colour(i), markerfacecolor=fill)
    for obstacle in run.scenario.environment.obstacles:
        plot_sphere(axes, obstacle.position_ned_m, obstacle.safety_distance_m)
    equal_box(axes)
    axes.invert_zaxis()
    axes.set_xlabel("east (m)")
    axes.set_ylabel("north (m)")
    axes.set_zlabel("depth (m)")
    axes.locator_params(axis="z", nbins=4)
    axes.view_init(elev=32, azim=-58)
    legend_below(canvas, [path_handle(), *vehicle_handles(run)])
    caption = (
        "Tracks in space, depth downwards, one scale on all axes. Hollow marks: starts; full marks: ends."
    )
    if run.scenario.environment.obstacles:
        caption += " The spheres are the safety distances of the obstacles."
    return Drawing(canvas, "Tracks in space", caption)


def _plot_obstacles(axes: Any, run: FlockRun) -> None:
    """Plot the obstacles at 0 s, and the tracks of those that move."""
    tracks = obstacle_positions_ned_m(run.recording, run.scenario)
    for number, obstacle in enumerate(run.scenario.environment.obstacles):
        plot_obstacle(axes, obstacle)
        if obstacle.is_moving:
            plot_plan_line(axes, tracks[:, number], color="black", linewidth=1.2, linestyle="dotted")


def _only_lost(run: FlockRun, i: int) -> FloatArray:
    """Return the (K + 1, 3) track of vehicle i after its loss, NaN before (m, map_ned)."""
    is_flying = np.isfinite(run.flock_ned_m[:, i])
    return np.where(is_flying, np.nan, run.recording.position_ned_m[:, i])


def _plot_hulls(axes: Any, run: FlockRun, k: int) -> None:
    """Draw the hulls at tick k to scale, each with its heading, and the time beside them."""
    radius_m = run.scenario.hull_radius_m
    plot_hulls(axes, run.recording, run.scenario, k)
    middle = run.centroid_ned_m[k, [1, 0]]
    inward = np.nanmean(run.path_ned_m[:, [1, 0]], axis=0) - middle
    label_at = middle + inward / max(float(np.hypot(*inward)), 1e-9) * (2.4 + 2.0 * radius_m)
    if np.isfinite(label_at).all():
        axes.text(
            *label_at, f"{run.t_s[k]:.0f} s", ha="center", va="center", fontsize=8, zorder=7, clip_on=True
        )


def _plan_legend(run: FlockRun) -> list[Line2D]:
    handles = [
        path_handle(),
        Line2D([], [], color="0.35", linestyle=(0, (2, 1)), linewidth=1.4, label="mean"),
    ]
    if run.scenario.environment.obstacles:
        handles.append(Line2D([], [], color="black", marker="x", linestyle="none", label="obstacle"))
    return [*handles, *vehicle_handles(run)]


TRACK_DRAWERS: dict[str, Callable[[FlockRun], Drawing | None]] = {"plan": _draw_plan, "space": _draw_space}
"""Figures by the names of their files."""
