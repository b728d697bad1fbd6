"""Figures of a flock over time: distances, errors and speeds."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure as Canvas

from auv_experiment.figures import Drawing
from auv_experiment.figures.flock_run import FlockRun
from auv_experiment.figures.plotting import (
    MAX_LINES,
    band_handle,
    legend_below,
    log_scale,
    marker,
    new_canvas,
    plot_thinned,
    side_by_side,
    span_time,
    vehicle_style,
)
from auv_experiment.metrics.distances import (
    centroid_path_error_m,
    consensus_error_m,
    pair_distances_m,
    vehicle_pairs,
)
from auv_experiment.recording import FloatArray

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario


def _draw_pair_distances(run: FlockRun) -> Drawing | None:
    distances_m = pair_distances_m(run.recording)
    if not np.isfinite(distances_m).any():
        return None
    canvas = new_canvas(3.6)
    first, rest = side_by_side(canvas, 2, (2, 3))
    split_s = _approach_window_s(run.t_s, distances_m)
    windows = ((first, run.t_s <= split_s), (rest, run.t_s >= split_s))
    for axes, window in windows:
        _plot_pairs(axes, run, run.t_s[window], distances_m[window])
        axes.set_xlabel("time (s)")
        span_time(axes, run.t_s[window])
    contact_m = 2.0 * run.scenario.hull_radius_m
    first.axhspan(0.0, contact_m, facecolor="0.8", hatch="////", edgecolor="0.6", linewidth=0.0, zorder=0)
    first.set_ylim(0.0, None)
    first.set_ylabel("distance between hull centres (m)")
    first.set_title(f"approach: the first {split_s:g} s")
    rest.set_title("after it (own scale)")
    if rest.get_ylim()[0] < contact_m:
        rest.axhline(contact_m, color="0.4", linewidth=1.2)
    _plot_spacing((first, rest), run.scenario)
    _plot_warning((first, rest), run.scenario)
    handles, labels = first.get_legend_handles_labels()
    handles.append(band_handle())
    legend_below(canvas, handles, [*labels, f"hulls touch (under {contact_m:g} m)"])
    smallest = np.nanargmin(np.nanmin(distances_m, axis=1))
    caption = (
        f"Distance of every pair. The smallest of the whole run is {np.nanmin(distances_m):.2f} m, at "
        f"{run.t_s[smallest]:.1f} s; hulls would touch at {contact_m:g} m. Left: the approach from the "
        "start. Right: the rest of the run, on its own scale."
    )
    if "d = " in "".join(labels):
        caption += " d is the distance below which the flocking law repels vehicles."
    return Drawing(canvas, "Pair distances", caption)


def _draw_path_error(run: FlockRun) -> Drawing | None:
    vehicle_m = np.linalg.norm(run.flock_ned_m - run.path_ned_m[:, np.newaxis], axis=-1)
    centroid_m = centroid_path_error_m(run.recording, run.scenario)
    if not np.isfinite(centroid_m).any():
        return None
    canvas, axes = _time_axes("distance to the reference point (m)")
    _plot_vehicles(axes, run, run.t_s, vehicle_m)
    plot_thinned(axes, run.t_s, centroid_m, color="black", linewidth=2.0, label="mean of the vehicles")
    log_scale(axes, np.concatenate([vehicle_m.ravel(), centroid_m]))
    legend_below(canvas, *axes.get_legend_handles_labels())
    caption = (
        "Distance to the moving reference point on the path, logarithmic. The thick line, the mean of the "
        "vehicles, should stay small; a single vehicle keeps its place in the flock, at a distance."
    )
    return Drawing(canvas, "Path error", caption)


def _draw_consensus_error(run: FlockRun) -> Drawing | None:
    error_m = consensus_error_m(run.recording)
    if not np.isfinite(error_m).any():
        return None
    t_s = run.t_s[:-1]
    canvas, axes = _time_axes("|own estimate − true mean| (m)")
    _plot_vehicles(axes, run, t_s, error_m)
    log_scale(axes, error_m)
    legend_below(canvas, *axes.get_legend_handles_labels())
    caption = (
        "Distance between each vehicle's own estimate of the flocking centre and the true mean of the "
        "positions, logarithmic. It does not go to zero: the consensus filter pulls every estimate slightly "
        "towards its own vehicle."
    )
    return Drawing(canvas, "Consensus error", caption)


def _draw_speed(run: FlockRun) -> Drawing | None:
    asked_mps = np.linalg.norm(run.recording.reference_velocity_ned_mps, axis=-1)
    flown_mps = np.linalg.norm(run.recording.velocity_body[..., :3], axis=-1)
    if not np.isfinite(asked_mps).any() or not np.isfinite(flown_mps).any():
        return None
    canvas = new_canvas(4.4)
    upper, lower = canvas.subplots(2, 1, sharex=True)
    _plot_vehicles(upper, run, run.t_s[:-1], asked_mps)
    _plot_vehicles(lower, run, run.t_s, flown_mps)
    for axes, values in ((upper, asked_mps), (lower, flown_mps)):
        if np.nanmax(values) > 20.0 * np.nanmedian(values):
            log_scale(axes, values)
        span_time(axes, run.t_s)
    upper.set_ylabel("commanded speed (m/s)")
    lower.set_ylabel("true speed (m/s)")
    lower.set_xlabel("time (s)")
    legend_below(canvas, *upper.get_legend_handles_labels())
    caption = (
        "Above, the speed that the flocking law commands; below, the true speed over ground. If they "
        "differ, the vehicle or its inner loop cannot follow."
    )
    return Drawing(canvas, "Commanded and true speed", caption)


def _approach_window_s(t_s: FloatArray, distances_m: FloatArray) -> float:
    """Return the end of the approach (s): when the farthest pair is as near as later."""
    farthest_m = np.where(np.isfinite(distances_m), distances_m, -np.inf).max(axis=1)
    is_near = farthest_m <= 1.1 * np.median(farthest_m[len(farthest_m) // 2 :])
    wanted_s = 1.2 * float(t_s[is_near.argmax()]) if is_near.any() else 0.0
    window_s = next((w for w in (10.0, 20.0, 30.0, 60.0, 80.0, 100.0, 200.0) if w >= wanted_s), 200.0)
    return window_s if window_s < 0.7 * t_s[-1] else 0.4 * float(t_s[-1])


def _plot_spacing(panels: tuple[Any, Any], scenario: Scenario) -> None:
    """Draw the distance below which the law repels vehicles, if the law has one."""
    law = scenario.agent.flocking
    spacing_m = None if law is None else getattr(law.params, "spacing_m", None)
    if spacing_m is None:
        return
    for axes in panels:
        low, high = axes.get_ylim()
        if low < spacing_m < high:
            axes.axhline(
                spacing_m, color="0.45", linewidth=0.9, linestyle=(0, (1, 1)), label=f"d = {spacing_m:g} m"
            )


def _plot_warning(panels: tuple[Any, Any], scenario: Scenario) -> None:
    """Draw the distance below which the report warns, if a vehicle states one."""
    near_m = max(handling.near_m for handling in scenario.handlings)
    if near_m > 0.0:
        panels[0].axhline(
            near_m, color="0.4", linewidth=0.9, linestyle="dashdot", label=f"near: {near_m:g} m"
        )
        if panels[1].get_ylim()[0] < near_m:
            panels[1].axhline(near_m, color="0.4", linewidth=0.9, linestyle="dashdot")


def _plot_pairs(axes: Any, run: FlockRun, t_s: FloatArray, distances_m: FloatArray) -> None:
    """Plot every pair, or range and median if there are too many to distinguish."""
    pairs = vehicle_pairs(run.recording.n_vehicles)
    if len(pairs) > MAX_LINES:
        low_m, high_m = np.nanmin(distances_m, axis=1), np.nanmax(distances_m, axis=1)
        axes.fill_between(t_s, low_m, high_m, color="0.75", linewidth=0, label=f"range of {len(pairs)} pairs")
        plot_thinned(axes, t_s, np.nanmedian(distances_m, axis=1), color="black", label="median")
        plot_thinned(axes, t_s, low_m, color="black", linestyle="dashed", label="smallest")
        return
    for p, (i, j) in enumerate(pairs):
        label = f"{run.recording.vehicle_ids[i]} – {run.recording.vehicle_ids[j]}"
        style = {**vehicle_style(p), "marker": marker(p)}
        plot_thinned(axes, t_s, distances_m[:, p], label=label, n_marks=7, first_mark=p / len(pairs), **style)


def _plot_vehicles(axes: Any, run: FlockRun, t_s: FloatArray, values: FloatArray) -> None:
    """Plot one line per vehicle, grey and without a name if there are too many."""
    n = run.recording.n_vehicles
    if n > MAX_LINES:
        for i in range(n):
            plot_thinned(axes, t_s, values[:, i], color="0.5", linewidth=0.4)
        return
    for i in range(n):
        style = {**vehicle_style(i), "marker": marker(i), "linewidth": 0.8}
        plot_thinned(axes, t_s, values[:, i], label=run.labels[i], n_marks=7, first_mark=i / n, **style)


def _time_axes(ylabel: str) -> tuple[Canvas, Any]:
    canvas = new_canvas(3.4)
    axes = canvas.add_subplot()
    axes.set_xlabel("time (s)")
    axes.set_ylabel(ylabel)
    axes.margins(x=0.0)
    return canvas, axes


HISTORY_DRAWERS: dict[str, Callable[[FlockRun], Drawing | None]] = {
    "pair_distances": _draw_pair_distances,
    "path_error": _draw_path_error,
    "consensus_error": _draw_consensus_error,
    "speed": _draw_speed,
}
"""Figures by the names of their files."""
