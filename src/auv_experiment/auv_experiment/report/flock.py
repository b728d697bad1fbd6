"""
Draw the figures of a run from its recording.

Each `_draw_*` function makes one figure from a `_Run` and returns it with its title and caption, or None
where the data do not exist. To add a figure, write such a function and name it in `_DRAWERS`. Plan views
have north up and east to the right; depth grows downwards. Vehicles differ in colour, line style and
marker, so that the figures can be read in grey. Long records are thinned to the smallest and the largest
value of every pixel column: no extreme is lost.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from auv_experiment.metrics import run as metrics
from auv_experiment.recording import FloatArray, Recording
from auv_experiment.report.plotting import (
    MAX_COLUMNS,
    STYLE,
    band_handle,
    colour,
    equal_box,
    legend_below,
    log_scale,
    mark,
    marker,
    plot_obstacle,
    plot_plan_line,
    plot_sphere,
    plot_thinned,
    round_step,
    save_canvas,
    span_time,
    vehicle_style,
)

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

DPI = 170
WIDTH_IN = 6.5
MAX_LINES = 10

_THESIS_FIGURES = {
    (scenario, name): number
    for scenario, tracks, pairs in (
        ("ch5_four_leaders", "5.5", "5.6"),
        ("ch5_one_leader", "5.7", "5.8"),
        ("ch5_obstacles", "5.9", "5.10"),
    )
    for name, number in (("plan", f"{tracks} (b)"), ("space", f"{tracks} (a)"), ("pair_distances", pairs))
}


@dataclass(frozen=True)
class Figure:
    """One figure on disk: where it is, what it is called, what to see in it."""

    path: Path
    title: str
    caption: str


@dataclass(frozen=True)
class Drawing:
    """A figure that is not on disk yet."""

    canvas: Canvas
    title: str
    caption: str


@dataclass(frozen=True, eq=False)
class _Run:
    """A recording and its scenario, with what several figures need."""

    recording: Recording
    scenario: Scenario

    @cached_property
    def t_s(self) -> FloatArray:
        return self.recording.t_s

    @cached_property
    def path_ned_m(self) -> FloatArray:
        return metrics.path_ned_m(self.recording, self.scenario)

    @cached_property
    def centroid_ned_m(self) -> FloatArray:
        return metrics.centroid_ned_m(self.recording)

    @cached_property
    def flock_ned_m(self) -> FloatArray:
        return metrics.flock_positions_ned_m(self.recording)

    @cached_property
    def labels(self) -> list[str]:
        """Vehicle names, the leaders marked where not every vehicle is one."""
        ids, leaders = self.recording.vehicle_ids, set(self.scenario.leaders)
        is_mixed = 0 < len(leaders) < len(ids)
        return [f"{name} (leader)" if is_mixed and name in leaders else name for name in ids]


def draw_figures(
    recording: Recording, scenario: Scenario, out_dir: Path, *, only: Collection[str] | None = None
) -> list[Figure]:
    """
    Draw every figure of a group whose data exist, as PNG files.

    Parameters
    ----------
    recording : Recording
        What happened.
    scenario : Scenario
        What was asked for: path, obstacles, leaders, hull radius, name.
    out_dir : Path
        Folder for the files; made if it does not exist.
    only : collection of str, optional
        Names of the figures to draw; all, if left out.

    Returns
    -------
    figures : list of Figure
        In the order in which a report shows them.

    """
    run = _Run(recording, scenario)
    drawers = {name: partial(draw, run) for name, draw in _DRAWERS.items() if only is None or name in only}
    return save_figures(drawers, scenario, out_dir)


def save_figures(
    drawers: Mapping[str, Callable[[], Drawing | None]], scenario: Scenario, out_dir: Path
) -> list[Figure]:
    """Draw, in the style of all figures, and write each drawing that comes of it as ``<name>.png``."""
    out_dir.mkdir(parents=True, exist_ok=True)
    figures = []
    for name, draw in drawers.items():
        with matplotlib.rc_context(STYLE):
            drawing = draw()
            if drawing is None:
                continue
            path = out_dir / f"{name}.png"
            save_canvas(drawing.canvas, path, DPI)
        thesis_figure = _THESIS_FIGURES.get((scenario.name, name))
        title = drawing.title + (f" (thesis Fig. {thesis_figure})" if thesis_figure else "")
        figures.append(Figure(path, title, drawing.caption))
    return figures


def _draw_plan(run: _Run) -> Drawing | None:
    if not np.isfinite(run.recording.position_ned_m).any():
        return None
    canvas = Canvas(figsize=(WIDTH_IN, 6.2), layout="constrained")
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
    for obstacle in run.scenario.environment.obstacles:
        plot_obstacle(axes, obstacle)
    instants = _instants(run.t_s)
    for k in instants:
        _plot_hulls(axes, run, k)
    axes.margins(0.06)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("east (m)")
    axes.set_ylabel("north (m)")
    legend_below(canvas, _plan_legend(run))
    times = ", ".join(f"{run.t_s[k]:.0f}" for k in instants)
    caption = (
        "Tracks seen from above, north up. The wide grey line is the path that the flock is to follow, the "
        "dashed grey line the mean of the vehicles. Hollow marks are starts, full marks are ends; the discs "
        f"are the hulls to scale with their heading, at {times} s."
    )
    if run.scenario.environment.obstacles:
        caption += (
            " Crosses are obstacles, each with the distance at which its repulsion begins; a track that "
            "crosses such a circle may also pass above or below."
        )
    return Drawing(canvas, "Tracks in the plane", caption)


def _draw_space(run: _Run) -> Drawing | None:
    positions = run.recording.position_ned_m
    if not np.isfinite(positions).any():
        return None
    canvas = Canvas(figsize=(WIDTH_IN, 5.2))
    axes: Any = canvas.add_axes((0.0, 0.12, 0.94, 0.88), projection="3d")
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
    legend_below(canvas, [_path_handle(), *_vehicle_handles(run)])
    caption = (
        "Tracks in space, depth downwards, one scale on all axes. Hollow marks: starts; full marks: ends."
    )
    if run.scenario.environment.obstacles:
        caption += " The spheres are the safety distances of the obstacles."
    return Drawing(canvas, "Tracks in space", caption)


def _draw_pair_distances(run: _Run) -> Drawing | None:
    distances_m = metrics.pair_distances_m(run.recording)
    if not np.isfinite(distances_m).any():
        return None
    canvas = Canvas(figsize=(WIDTH_IN, 3.6), layout="constrained")
    first, rest = canvas.subplots(1, 2, width_ratios=(2, 3))
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
    handles, labels = first.get_legend_handles_labels()
    handles.append(band_handle())
    legend_below(canvas, handles, [*labels, f"hulls touch (under {contact_m:g} m)"])
    smallest = np.nanargmin(np.nanmin(distances_m, axis=1))
    caption = (
        f"Distance of every pair. The smallest of the whole run is {np.nanmin(distances_m):.2f} m, at "
        f"{run.t_s[smallest]:.1f} s; hulls would touch at {contact_m:g} m. Left the approach from the start, "
        "right the rest of the run on a scale of its own."
    )
    if "d = " in "".join(labels):
        caption += " d is the distance below which the flocking law pushes vehicles apart."
    return Drawing(canvas, "Pair distances", caption)


def _draw_path_error(run: _Run) -> Drawing | None:
    vehicle_m = np.linalg.norm(run.flock_ned_m - run.path_ned_m[:, np.newaxis], axis=-1)
    centroid_m = metrics.centroid_path_error_m(run.recording, run.scenario)
    if not np.isfinite(centroid_m).any():
        return None
    canvas, axes = _time_axes("distance to the reference point (m)")
    _plot_vehicles(axes, run, run.t_s, vehicle_m)
    plot_thinned(axes, run.t_s, centroid_m, color="black", linewidth=2.0, label="mean of the vehicles")
    log_scale(axes, np.concatenate([vehicle_m.ravel(), centroid_m]))
    legend_below(canvas, *axes.get_legend_handles_labels())
    caption = (
        "Distance to the moving reference point on the path, logarithmic. The thick line, the mean of the "
        "vehicles, is what is to stay small; a single vehicle keeps its place in the flock, so a distance."
    )
    return Drawing(canvas, "Path error", caption)


def _draw_consensus_error(run: _Run) -> Drawing | None:
    error_m = metrics.consensus_error_m(run.recording)
    if not np.isfinite(error_m).any():
        return None
    t_s = run.t_s[:-1]
    canvas, axes = _time_axes("|own estimate − true mean| (m)")
    _plot_vehicles(axes, run, t_s, error_m)
    log_scale(axes, error_m)
    legend_below(canvas, *axes.get_legend_handles_labels())
    caption = (
        "Distance between each vehicle's own estimate of the flocking centre and the true mean of the "
        "positions, logarithmic. It does not go to zero: the consensus filter pulls every estimate a "
        "little towards its own vehicle."
    )
    return Drawing(canvas, "Consensus error", caption)


def _draw_speed(run: _Run) -> Drawing | None:
    asked_mps = np.linalg.norm(run.recording.reference_velocity_ned_mps, axis=-1)
    flown_mps = np.linalg.norm(run.recording.velocity_body[..., :3], axis=-1)
    if not np.isfinite(asked_mps).any() or not np.isfinite(flown_mps).any():
        return None
    canvas = Canvas(figsize=(WIDTH_IN, 4.4), layout="constrained")
    upper, lower = canvas.subplots(2, 1, sharex=True)
    _plot_vehicles(upper, run, run.t_s[:-1], asked_mps)
    _plot_vehicles(lower, run, run.t_s, flown_mps)
    for axes, values in ((upper, asked_mps), (lower, flown_mps)):
        if np.nanmax(values) > 20.0 * np.nanmedian(values):
            log_scale(axes, values)
        span_time(axes, run.t_s)
    upper.set_ylabel("speed asked for (m/s)")
    lower.set_ylabel("speed flown (m/s)")
    lower.set_xlabel("time (s)")
    legend_below(canvas, *upper.get_legend_handles_labels())
    caption = (
        "Above, the speed that the flocking law asks for; below, the true speed over ground. "
        "Where the two differ the vehicle or its inner loop cannot follow."
    )
    return Drawing(canvas, "Speed asked for and flown", caption)


def _only_lost(run: _Run, i: int) -> FloatArray:
    """Return the (K + 1, 3) track of vehicle i after its loss, NaN before (m, map_ned)."""
    is_flying = np.isfinite(run.flock_ned_m[:, i])
    return np.where(is_flying, np.nan, run.recording.position_ned_m[:, i])


def _plot_hulls(axes: Any, run: _Run, k: int) -> None:
    """Draw the hulls at tick k to scale, each with its heading, and the time beside them."""
    radius_m = run.scenario.hull_radius_m
    positions = run.recording.position_ned_m[k]
    for i, (north, east, _) in enumerate(positions):
        axes.add_patch(Circle((east, north), radius_m, facecolor=colour(i), edgecolor="white", zorder=5))
        w, x, y, z = run.recording.attitude_quat_wxyz[k, i]
        ahead = np.array([2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z)])  # body x axis: east, north
        tip = np.array([east, north]) + 2.0 * radius_m * ahead
        axes.plot([east, tip[0]], [north, tip[1]], color=colour(i), linewidth=1.0, zorder=5)
    middle = run.centroid_ned_m[k, [1, 0]]
    inward = np.nanmean(run.path_ned_m[:, [1, 0]], axis=0) - middle
    label_at = middle + inward / max(float(np.hypot(*inward)), 1e-9) * (2.4 + 2.0 * radius_m)
    if np.isfinite(label_at).all():
        axes.text(
            *label_at, f"{run.t_s[k]:.0f} s", ha="center", va="center", fontsize=8, zorder=7, clip_on=True
        )


def _instants(t_s: FloatArray) -> list[int]:
    """Return the ticks of some six round times after the start."""
    step_s = round_step(float(t_s[-1]) / 6.0)
    times_s = np.arange(step_s, t_s[-1] + 1e-9, step_s)
    ticks: list[int] = np.unique(np.clip(np.searchsorted(t_s, times_s - 1e-9), 0, len(t_s) - 1)).tolist()
    return ticks


def _approach_window_s(t_s: FloatArray, distances_m: FloatArray) -> float:
    """Return how long the approach is shown on its own: until the farthest pair is as near as later (s)."""
    farthest_m = np.where(np.isfinite(distances_m), distances_m, -np.inf).max(axis=1)
    is_near = farthest_m <= 1.1 * np.median(farthest_m[len(farthest_m) // 2 :])
    wanted_s = 1.2 * float(t_s[is_near.argmax()]) if is_near.any() else 0.0
    window_s = next((w for w in (10.0, 20.0, 30.0, 60.0, 80.0, 100.0, 200.0) if w >= wanted_s), 200.0)
    return window_s if window_s < 0.7 * t_s[-1] else 0.4 * float(t_s[-1])


def _plot_spacing(panels: tuple[Any, Any], scenario: Scenario) -> None:
    """Draw the distance below which the law pushes vehicles apart, where the law has one."""
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


def _plot_pairs(axes: Any, run: _Run, t_s: FloatArray, distances_m: FloatArray) -> None:
    """Plot every pair, or the range and median where there are too many to tell apart."""
    pairs = metrics.vehicle_pairs(run.recording.n_vehicles)
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


def _plot_vehicles(axes: Any, run: _Run, t_s: FloatArray, values: FloatArray) -> None:
    """Plot one line for each vehicle, grey and without a name where there are too many."""
    n = run.recording.n_vehicles
    if n > MAX_LINES:
        for i in range(n):
            plot_thinned(axes, t_s, values[:, i], color="0.5", linewidth=0.4)
        return
    for i in range(n):
        style = {**vehicle_style(i), "marker": marker(i), "linewidth": 0.8}
        plot_thinned(axes, t_s, values[:, i], label=run.labels[i], n_marks=7, first_mark=i / n, **style)


def _time_axes(ylabel: str) -> tuple[Canvas, Any]:
    canvas = Canvas(figsize=(WIDTH_IN, 3.4), layout="constrained")
    axes = canvas.add_subplot()
    axes.set_xlabel("time (s)")
    axes.set_ylabel(ylabel)
    axes.margins(x=0.0)
    return canvas, axes


def _path_handle() -> Line2D:
    return Line2D([], [], color="0.55", linewidth=3.0, alpha=0.55, label="path")


def _vehicle_handles(run: _Run) -> list[Line2D]:
    if run.recording.n_vehicles > MAX_LINES:
        return []
    return [
        Line2D([], [], marker=marker(i), label=label, **vehicle_style(i))
        for i, label in enumerate(run.labels)
    ]


def _plan_legend(run: _Run) -> list[Line2D]:
    handles = [
        _path_handle(),
        Line2D([], [], color="0.35", linestyle=(0, (2, 1)), linewidth=1.4, label="mean"),
    ]
    if run.scenario.environment.obstacles:
        handles.append(Line2D([], [], color="black", marker="x", linestyle="none", label="obstacle"))
    return [*handles, *_vehicle_handles(run)]


_DRAWERS: dict[str, Callable[[_Run], Drawing | None]] = {
    "plan": _draw_plan,
    "space": _draw_space,
    "pair_distances": _draw_pair_distances,
    "path_error": _draw_path_error,
    "consensus_error": _draw_consensus_error,
    "speed": _draw_speed,
}
