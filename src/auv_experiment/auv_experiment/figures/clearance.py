"""The figure of the distances that a flock keeps from obstacles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from auv_experiment.figures import Drawing
from auv_experiment.figures.flock_run import FlockRun
from auv_experiment.figures.plotting import (
    MAX_LINES,
    band_handle,
    legend_below,
    marker,
    new_canvas,
    plot_thinned,
    span_time,
    vehicle_style,
)
from auv_experiment.metrics.distances import obstacle_distances_m


def _draw_clearance(run: FlockRun) -> Drawing | None:
    """Draw the distance of the nearest vehicle to each obstacle, or of all together if there are many."""
    distances_m = obstacle_distances_m(run.recording, run.scenario)
    if distances_m.shape[2] == 0 or not np.isfinite(distances_m).any():
        return None
    nearest_m = np.nanmin(np.where(np.isfinite(distances_m), distances_m, np.inf), axis=1)
    names = [str(number + 1) for number in range(nearest_m.shape[1])]
    if len(names) > MAX_LINES:
        nearest_m, names = nearest_m.min(axis=1, keepdims=True), [f"nearest of {len(names)}"]
    canvas = new_canvas(3.4)
    axes = canvas.add_subplot()
    for i, name in enumerate(names):
        style = {**vehicle_style(i), "marker": marker(i)}
        first = i / len(names)
        plot_thinned(axes, run.t_s, nearest_m[:, i], label=name, n_marks=7, first_mark=first, **style)
    touch_m = run.scenario.hull_radius_m
    axes.axhspan(0.0, touch_m, facecolor="0.8", hatch="////", edgecolor="0.6", linewidth=0.0, zorder=0)
    axes.set_ylim(0.0, max(6.0 * touch_m, 2.0 * float(nearest_m.min()), 4.0))
    axes.set_xlabel("time (s)")
    axes.set_ylabel("distance to hull centre (m)")
    span_time(axes, run.t_s)
    handles, labels = axes.get_legend_handles_labels()
    legend_below(canvas, [*handles, band_handle()], [*labels, f"inside a hull (under {touch_m:g} m)"])
    at_s = run.t_s[nearest_m.min(axis=1).argmin()]
    caption = (
        "Distance of each obstacle, numbered as in the scenario, to the centre of the nearest hull. "
        f"The smallest is {nearest_m.min():.2f} m, at {at_s:.1f} s."
    )
    return Drawing(canvas, "Distances to obstacles", caption)


CLEARANCE_DRAWERS: dict[str, Callable[[FlockRun], Drawing | None]] = {"obstacle_distances": _draw_clearance}
"""Figures by the names of their files."""
