"""Figures of a run whose vehicles follow a course: tracks, heading and depth over time, actuators."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D

from auv_control.courses import line_of_sight
from auv_control.guidance.paths import make_path
from auv_core.models import make_model
from auv_experiment.figures import Drawer, Drawing
from auv_experiment.figures.hulls import plot_headings, plot_hulls
from auv_experiment.figures.plotting import (
    legend_below,
    mark,
    new_canvas,
    plot_plan_line,
    plot_thinned,
    round_ticks,
    set_height,
    span_time,
    vehicle_style,
)
from auv_experiment.metrics.courses.course import heading_error_rad
from auv_experiment.metrics.path import heading_rad
from auv_experiment.recording import FloatArray, Recording
from auv_flocking.course_task import CROSS_TRACK, DEPTH, SPEED
from auv_flocking.fleets import lanes

if TYPE_CHECKING:
    from auv_experiment.scenario.schema import Scenario

_PATH_POINTS = 400
_COURSE_STYLE: dict[str, Any] = {"color": "0.6", "linewidth": 3.0, "alpha": 0.5}


def course_drawers(recording: Recording, scenario: Scenario) -> dict[str, Drawer]:
    """Return the drawing functions of a run whose vehicles follow a course, by name."""
    if recording.law_state.shape[2] <= CROSS_TRACK or not np.isfinite(recording.position_ned_m).any():
        return {}

    def drawn(draw: Callable[..., tuple[str, str]]) -> Drawing:
        canvas = new_canvas()
        return Drawing(canvas, *draw(canvas, recording, scenario))

    return {name: partial(drawn, draw) for name, draw in _DRAWERS.items()}


def _draw_plan(canvas: Canvas, recording: Recording, scenario: Scenario) -> tuple[str, str]:
    set_height(canvas, 6.0)
    axes = canvas.add_subplot()
    path = _path_ned_m(scenario)
    if path is not None:
        plot_plan_line(axes, path, zorder=1, **_COURSE_STYLE)
    for i in range(recording.n_vehicles):
        plot_plan_line(axes, recording.position_ned_m[:, i], zorder=4, **vehicle_style(i))
        mark(axes, recording.position_ned_m[0, i], i, is_filled=False)
        mark(axes, recording.position_ned_m[-1, i], i, is_filled=True)
    instants = round_ticks(recording.t_s)
    for tick in instants:
        plot_hulls(axes, recording, scenario, tick)
        plot_headings(axes, recording, tick)
    axes.margins(0.06)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("east (m)")
    axes.set_ylabel("north (m)")
    legend_below(canvas, _handles(recording, "" if path is None else "path"))
    over = "" if path is None else ", over the path (wide and grey)"
    times = ", ".join(f"{recording.t_s[tick]:.0f}" for tick in instants)
    return "Tracks", (
        f"Tracks seen from above, north up{over}. Hollow marks are starts, full marks ends; arrowheads are "
        f"headings, on hulls to scale, at {times} s."
    )


def _draw_course(canvas: Canvas, recording: Recording, _: Scenario) -> tuple[str, str]:
    t_s = recording.t_s[:-1]
    true_rad = np.unwrap(heading_rad(recording)[:-1], axis=0)
    asked = recording.law_state
    rows = (
        ("heading (deg)", np.degrees(true_rad), np.degrees(true_rad + heading_error_rad(recording))),
        ("depth (m)", recording.position_ned_m[:-1, :, 2], asked[..., DEPTH]),
        ("speed ahead (m/s)", recording.velocity_body[:-1, :, 0], asked[..., SPEED]),
    )
    set_height(canvas, 6.0)
    for axes, (label, true, commanded) in zip(canvas.subplots(len(rows), 1, sharex=True), rows, strict=True):
        for i in range(recording.n_vehicles):
            plot_thinned(axes, t_s, commanded[:, i], **_COURSE_STYLE)
            plot_thinned(axes, t_s, true[:, i], **vehicle_style(i))
        axes.set_ylabel(label)
        if label.startswith("depth"):
            axes.invert_yaxis()
    axes.set_xlabel("time (s)")
    span_time(axes, t_s)
    legend_below(canvas, _handles(recording, "course"))
    return "Heading, depth and speed", "True values over what the course asks for (wide and grey)."


def _draw_actuators(canvas: Canvas, recording: Recording, scenario: Scenario) -> tuple[str, str]:
    t_s = recording.t_s
    fleet = [make_model(vehicle.model).actuators for vehicle in scenario.vehicles]
    actuators = max(fleet, key=len)
    set_height(canvas, 1.1 + 1.6 * len(actuators))
    grid: Any = canvas.subplots(len(actuators), 1, sharex=True, squeeze=False)[:, 0]
    for column, (axes, actuator) in enumerate(zip(grid, actuators, strict=True)):
        is_angle = actuator.unit == "rad"
        for i in (i for i, own in enumerate(fleet) if own == actuators):
            outputs = recording.actuator_output[:, i, column]
            plot_thinned(axes, t_s, np.degrees(outputs) if is_angle else outputs, **vehicle_style(i))
        axes.set_ylabel(f"{actuator.name.replace('_', ' ')} ({'deg' if is_angle else actuator.unit})")
    grid[-1].set_xlabel("time (s)")
    span_time(grid[-1], t_s)
    legend_below(canvas, _handles(recording, ""))
    return "Actuators", "Outputs of the actuators: what acts, after the delay of each."


def _path_ned_m(scenario: Scenario) -> FloatArray | None:
    """Return points of the path of the course or the fleet (m; NED), None without one."""
    section = scenario.agent.course or scenario.agent.fleet
    params = section.params if section else None
    if not isinstance(params, line_of_sight.Params | lanes.Params):
        return None
    track = make_path(params.path).track
    points = [track.at(track.length_m * k / _PATH_POINTS) for k in range(_PATH_POINTS + 1)]
    return np.array([(point.north_m, point.east_m, params.depth_m) for point in points])


def _handles(recording: Recording, course: str) -> list[Line2D]:
    handles = [Line2D([], [], label=course, **_COURSE_STYLE)] if course else []
    if recording.n_vehicles > 10:
        return handles
    return handles + [
        Line2D([], [], label=name, **vehicle_style(i)) for i, name in enumerate(recording.vehicle_ids)
    ]


_DRAWERS = {"course_plan": _draw_plan, "course_errors": _draw_course, "actuators": _draw_actuators}
