"""
Drawings of chapters 5 and 6 in the thesis's axes: tracks in space and in the plane, distances over time.

As in the thesis, x points to the right, y upwards, and z (a depth) increases upwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure as Canvas

from auv_experiment.figures.plotting import legend_below, plot_thinned, vehicle_style
from auv_experiment.metrics.distances import pair_distances_m, path_ned_m, vehicle_pairs
from auv_thesis.items import Run

Limits = tuple[float, float]
_SIZE_IN = (6.5, 3.6)


def draw_tracks(canvas: Canvas, run: Run, space: Sequence[Limits], plane: Sequence[Limits]) -> None:
    """
    Draw all tracks and the path, (a) in space and (b) in the plane.

    Parameters
    ----------
    canvas : Figure
        Empty Matplotlib figure.
    run : Run
        A flock.
    space, plane : sequences of (low, high)
        Limits of x, y, z and of x, y (m).

    """
    canvas.set_layout_engine("none")
    canvas.set_size_inches(_SIZE_IN[0], 4.0)
    in_space: Any = canvas.add_axes((0.0, 0.18, 0.5, 0.8), projection="3d")
    in_plane: Any = canvas.add_axes((0.64, 0.24, 0.35, 0.7))
    positions = run.recording.position_ned_m
    path = path_ned_m(run.recording, run.scenario)
    names = vehicle_names(run)
    handles = []
    for index, name in enumerate(names):
        track = positions[:, index]
        style = {**vehicle_style(index), "linewidth": 0.9, "label": name}
        in_space.plot(track[::5, 0], track[::5, 1], track[::5, 2], **style)
        handles += in_plane.plot(track[:, 0], track[:, 1], **style)
        in_plane.plot(track[0, 0], track[0, 1], "o", color=style["color"], markersize=3.0, clip_on=True)
    for axes, columns in ((in_space, (0, 1, 2)), (in_plane, (0, 1))):
        lines = axes.plot(
            *(path[:, k] for k in columns), color="0.55", linewidth=2.5, alpha=0.6, label="desired"
        )
        _mark_obstacles(axes, run, columns)
    handles += lines
    for letter, limits in zip("xyz", space, strict=False):
        getattr(in_space, f"set_{letter}lim")(limits)
        getattr(in_space, f"set_{letter}label")(f"{letter} (m)")
    in_space.view_init(elev=24.0, azim=-58.0)
    in_space.set_box_aspect(None, zoom=0.82)
    in_plane.set_xlim(plane[0])
    in_plane.set_ylim(plane[1])
    in_plane.set_xlabel("x (m)")
    in_plane.set_ylabel("y (m)")
    in_plane.set_aspect("equal", adjustable="box")
    legend_below(canvas, handles)


def draw_distances(
    axes: Any, run: Run, time_s: Limits, distance_m: Limits, *, pairs: Sequence[int] = ()
) -> None:
    """Draw the distances of all pairs, or of the given ones, over time in the given axes (s, m)."""
    t_s, distances_m = run.recording.t_s, pair_distances_m(run.recording)
    shown = np.flatnonzero((t_s >= time_s[0]) & (t_s <= time_s[1]))
    for index, name in enumerate(pair_names(run)):
        if not pairs or index in pairs:
            style = {**vehicle_style(index), "linewidth": 0.9}
            plot_thinned(axes, t_s[shown], distances_m[shown, index], label=name, **style)
    axes.set_xlim(time_s)
    axes.set_ylim(distance_m)
    axes.set_xlabel("t (s)")
    axes.set_ylabel("d (m)")


def distance_panels(canvas: Canvas, count: int) -> list[Any]:
    """Return `count` axes side by side."""
    canvas.set_size_inches(*_SIZE_IN)
    return [canvas.add_subplot(1, count, column + 1) for column in range(count)]


def legend_of(canvas: Canvas, axes: Any) -> None:
    """Place the legend of the axes below the figure."""
    handles, labels = axes.get_legend_handles_labels()
    legend_below(canvas, handles, labels)


def vehicle_names(run: Run) -> list[str]:
    """Return "leader 1" and so on, in the thesis's words."""
    leads = [vehicle.id in run.scenario.leaders for vehicle in run.scenario.vehicles]
    if sum(leads) == 1:
        numbers = np.cumsum([not lead for lead in leads]).tolist()
        return ["leader" if lead else f"follower {n}" for lead, n in zip(leads, numbers, strict=True)]
    return [f"leader {index + 1}" for index in range(len(leads))]


def pair_names(run: Run) -> list[str]:
    """Return "L F1", "F1 F2" and so on for all pairs, in the order of `vehicle_pairs`."""
    short = [
        name.replace("leader", "L").replace("follower", "F").replace(" ", "") for name in vehicle_names(run)
    ]
    return [f"{short[i]} {short[j]}" for i, j in vehicle_pairs(run.recording.n_vehicles)]


def _mark_obstacles(axes: Any, run: Run, columns: Sequence[int]) -> None:
    for obstacle in run.scenario.environment.obstacles:
        place = [[obstacle.position_ned_m[k]] for k in columns]
        axes.plot(*place, "X", color="black", markersize=7, linestyle="none")
