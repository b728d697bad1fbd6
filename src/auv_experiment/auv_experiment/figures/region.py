"""
Figures of a run whose vehicles steer to a ring: tracks in space and from above, distances, forces.

The report and the reproduction of the thesis's figures both use the drawing functions that take axes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from auv_control.region import Ring
from auv_experiment.figures import Drawer, Drawing
from auv_experiment.figures.plotting import (
    band_handle,
    colour,
    equal_box,
    legend_below,
    log_scale,
    mark,
    marker,
    new_canvas,
    plot_plan_line,
    plot_thinned,
    set_height,
    side_by_side,
    space_axes,
    span_time,
    vehicle_style,
)
from auv_experiment.metrics import region as metrics_region
from auv_experiment.metrics.distances import pair_distances_m, vehicle_pairs
from auv_experiment.recording import FloatArray, Recording

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

EAST_NORTH_DOWN = (1, 0, 2)
MAX_POINTS = 2000
_RING_COLOUR = "0.45"


def region_drawers(recording: Recording, scenario: Scenario) -> dict[str, Drawer]:
    """Return the drawing functions of a run to a region, by name."""
    ring = metrics_region.ring_of(scenario)
    if ring is None or not np.isfinite(recording.position_ned_m).any():
        return {}

    def drawn(draw: Callable[..., tuple[str, str]]) -> Drawing:
        canvas = new_canvas(layout=None if draw is _draw_space else "constrained")
        return Drawing(canvas, *draw(canvas, recording, scenario, ring))

    return {name: partial(drawn, draw) for name, draw in _DRAWERS.items()}


def plot_tracks_in_space(axes: Any, recording: Recording, ring: Ring, order: Sequence[int]) -> None:
    """
    Plot the ring and all tracks into axes in space.

    Parameters
    ----------
    axes : Axes3D
        Axes in space.
    recording : Recording
        The run.
    ring : Ring
        The ring of the law.
    order : sequence of 3 int
        NED component along each axis of the plot; (1, 0, 2) is east, north, down.

    """
    _plot_ring_in_space(axes, ring, order)
    every = max(1, recording.n_ticks // MAX_POINTS)
    for i in range(recording.n_vehicles):
        track = recording.position_ned_m[:, i]
        shown = np.vstack([track[::every], track[-1:]])
        axes.plot(*_arranged(shown, order), linewidth=1.0, **vehicle_style(i))
        for k, fill in ((0, "white"), (-1, colour(i))):
            axes.plot(
                *_arranged(track[k : k + 1 or None], order), marker(i), color=colour(i), markerfacecolor=fill
            )


def vehicle_handles(recording: Recording) -> list[Line2D]:
    """Return the legend entries of the vehicles and the ring."""
    handles = [
        Line2D([], [], marker=marker(i), label=name, **vehicle_style(i))
        for i, name in enumerate(recording.vehicle_ids)
    ]
    return [*handles, Line2D([], [], color=_RING_COLOUR, linewidth=1.6, label="ring")]


def plot_ring_from_above(axes: Any, ring: Ring) -> None:
    """Plot the ring from above, north up: the ring grey, its hole white."""
    north, east, _ = ring.centre_ned_m
    for radius_m, face in ((ring.outer_radius_m, "0.88"), (ring.inner_radius_m, "white")):
        axes.add_patch(
            Circle((east, north), radius_m, facecolor=face, edgecolor=_RING_COLOUR, linewidth=1.2, zorder=0)
        )


def _plot_ring_in_space(axes: Any, ring: Ring, order: Sequence[int]) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 61)
    half_m = 0.5 * ring.height_m
    for radius_m in (ring.inner_radius_m, ring.outer_radius_m):
        walls = [_circle(ring, angle, radius_m, height_m) for height_m in (-half_m, half_m)]
        for circle in walls:
            axes.plot(*_arranged(circle, order), color=_RING_COLOUR, linewidth=1.0)
        stacked = np.stack(walls)
        axes.plot_surface(
            *[stacked[..., component] for component in order], color="0.6", alpha=0.3, linewidth=0
        )


def _circle(ring: Ring, angle: FloatArray, radius_m: float, height_m: float) -> FloatArray:
    """Return the (n, 3) points of a level circle about the ring's axis (m; NED)."""
    north, east, down = ring.centre_ned_m
    points: FloatArray = np.stack(
        [
            north + radius_m * np.cos(angle),
            east + radius_m * np.sin(angle),
            np.full_like(angle, down + height_m),
        ],
        axis=-1,
    )
    return points


def _arranged(points: FloatArray, order: Sequence[int]) -> list[FloatArray]:
    return [points[:, component] for component in order]


def _draw_space(canvas: Canvas, recording: Recording, scenario: Scenario, ring: Ring) -> tuple[str, str]:
    set_height(canvas, 5.2)
    axes = space_axes(canvas)
    plot_tracks_in_space(axes, recording, ring, EAST_NORTH_DOWN)
    equal_box(axes)
    axes.invert_zaxis()
    axes.set_xlabel("east (m)")
    axes.set_ylabel("north (m)")
    axes.set_zlabel("depth (m)")
    axes.locator_params(nbins=5)
    axes.view_init(elev=24, azim=-58)
    legend_below(canvas, vehicle_handles(recording))
    caption = (
        "Tracks in space, depth downwards, and the ring between its two cylinders. Hollow marks: starts; "
        "full marks: ends."
    )
    return "Tracks to the ring", caption


def _draw_plan(canvas: Canvas, recording: Recording, scenario: Scenario, ring: Ring) -> tuple[str, str]:
    set_height(canvas, 3.9)
    whole, near = side_by_side(canvas, 2)
    for axes in (whole, near):
        plot_ring_from_above(axes, ring)
        for i in range(recording.n_vehicles):
            track = recording.position_ned_m[:, i]
            plot_plan_line(axes, track, **vehicle_style(i))
            mark(axes, track[0], i, is_filled=False)
            mark(axes, track[-1], i, is_filled=True)
        axes.set_aspect("equal", adjustable="box")
        axes.set_xlabel("east (m)")
    for i in range(recording.n_vehicles):
        north, east, _ = recording.position_ned_m[-1, i]
        hull = Circle((east, north), scenario.hull_radius_m, fill=False, edgecolor=colour(i), zorder=5)
        near.add_patch(hull)
    north, east, _ = ring.centre_ned_m
    margin_m = 1.4 * ring.outer_radius_m
    near.set_xlim(east - margin_m, east + margin_m)
    near.set_ylim(north - margin_m, north + margin_m)
    whole.set_ylabel("north (m)")
    whole.set_title("whole run")
    near.set_title("the ring")
    legend_below(canvas, vehicle_handles(recording))
    caption = (
        "Seen from above, north up; the ring is grey, its hole white. Hollow marks are starts, full marks "
        "ends, the thin circles on the right are the hulls at the end, to scale. Vehicles that seem to "
        "touch may be at different depths."
    )
    return "Tracks from above", caption


def _draw_distances(canvas: Canvas, recording: Recording, scenario: Scenario, ring: Ring) -> tuple[str, str]:
    set_height(canvas, 5.0)
    upper, lower = canvas.subplots(2, 1, sharex=True)
    t_s = recording.t_s
    to_ring_m = metrics_region.ring_distances_m(recording, ring)
    for i in range(recording.n_vehicles):
        shown = np.where(to_ring_m[:, i] > 0.0, to_ring_m[:, i], np.nan)
        plot_thinned(upper, t_s, shown, **vehicle_style(i))
    upper.axhline(metrics_region.REACHED_M, color="0.4", linewidth=1.0, linestyle="dashed")
    log_scale(upper, to_ring_m)
    upper.set_ylim(0.3 * metrics_region.REACHED_M, None)
    upper.set_ylabel("distance to the ring (m)")
    pairs_m = pair_distances_m(recording)
    for p, (i, j) in enumerate(vehicle_pairs(recording.n_vehicles)):
        name = f"{recording.vehicle_ids[i]} – {recording.vehicle_ids[j]}"
        plot_thinned(lower, t_s, pairs_m[:, p], label=name, **vehicle_style(p))
    contact_m = 2.0 * scenario.hull_radius_m
    lower.axhspan(0.0, contact_m, facecolor="0.8", hatch="////", edgecolor="0.6", linewidth=0.0, zorder=0)
    lower.set_ylim(0.0, None)
    lower.set_ylabel("distance of a pair (m)")
    lower.set_xlabel("time (s)")
    span_time(lower, t_s)
    upper.legend(handles=vehicle_handles(recording)[:-1], loc="upper right", ncols=3)
    handles, labels = lower.get_legend_handles_labels()
    handles.append(band_handle())
    legend_below(canvas, handles, [*labels, f"hulls touch (under {contact_m:g} m)"])
    caption = (
        "Above, distance of each hull's centre to the ring, logarithmic; a line ends where the vehicle is "
        f"inside. Under the dashed line, {metrics_region.REACHED_M:g} m, it counts as arrived. Below, "
        "distance of each pair of centres."
    )
    return "Distances to the ring and to each other", caption


def _draw_forces(canvas: Canvas, recording: Recording, scenario: Scenario, ring: Ring) -> tuple[str, str]:
    set_height(canvas, 4.4)
    upper, lower = canvas.subplots(2, 1, sharex=True)
    forces_n = metrics_region.forces_n(recording)
    speeds_mps = metrics_region.speeds_mps(recording)
    for i in range(recording.n_vehicles):
        plot_thinned(upper, recording.t_s[:-1], forces_n[:, i], **vehicle_style(i))
        plot_thinned(lower, recording.t_s, speeds_mps[:, i], **vehicle_style(i))
    log_scale(upper, forces_n)
    log_scale(lower, speeds_mps)
    upper.set_ylabel("commanded force (N)")
    lower.set_ylabel("speed (m/s)")
    lower.set_xlabel("time (s)")
    span_time(lower, recording.t_s)
    legend_below(canvas, vehicle_handles(recording)[:-1])
    caption = (
        f"Magnitude of the commanded force, at most {forces_n.max(initial=0.0):.0f} N, and speed, "
        f"at most {speeds_mps.max(initial=0.0):.1f} m/s. Both logarithmic."
    )
    return "Forces and speeds", caption


_DRAWERS = {
    "region_space": _draw_space,
    "region_plan": _draw_plan,
    "region_distances": _draw_distances,
    "region_forces": _draw_forces,
}
