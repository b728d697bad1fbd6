"""Figures 3.4-3.14: the formations of chapter 3 with the thesis's settings, on the thesis's axes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure as Canvas

from auv_experiment.figures.plotting import plot_thinned, vehicle_style
from auv_experiment.metrics.formations.errors import errors, rate_errors, signed_distances_m
from auv_experiment.metrics.path import path_points_ned
from auv_experiment.recording import FloatArray
from auv_thesis.ch3.runs import CIRCLE, SPIRAL
from auv_thesis.items import Figure, Run

Limits = tuple[float, float]
Draw = Callable[[Canvas, list[Run]], None]


@dataclass(frozen=True)
class _View:
    """Limits of the time axis (s) and of the value axis, and the time interval (s) that an inset enlarges."""

    span_s: Limits
    values: Limits
    inset_s: Limits | None = None
    place: tuple[float, float, float, float] = (0.3, 0.32, 0.5, 0.5)


def _lines(axes: Any, t_s: FloatArray, columns: FloatArray, names: Sequence[str], view: _View) -> None:
    """Plot one line per column, with an inset if the view has one."""
    _plot(axes, t_s, columns, names, view.span_s)
    axes.set_ylim(*view.values)
    axes.set_xlabel("t (s)")
    if len(names) > 1:
        axes.legend(loc="upper right", fontsize=7)
    if view.inset_s is not None:
        inset = axes.inset_axes(view.place)
        _plot(inset, t_s, columns, names, view.inset_s)
        inset.tick_params(labelsize=7)


def _plot(axes: Any, t_s: FloatArray, columns: FloatArray, names: Sequence[str], span_s: Limits) -> None:
    times_s = t_s[: len(columns)]
    shown = (times_s >= span_s[0]) & (times_s <= span_s[1])
    for i, name in enumerate(names):
        plot_thinned(axes, times_s[shown], columns[shown, i], label=name, **vehicle_style(i))
    axes.set_xlim(*span_s)


def _plan_and_space() -> Draw:
    """Return the drawer of Fig. 3.4: (a) x to the right and y up, (b) in space."""

    def draw(canvas: Canvas, runs: list[Run]) -> None:
        plan = canvas.add_subplot(1, 2, 1)
        _tracks(plan, runs[0], dimensions=2)
        plan.set_xlim(-40.0, 40.0)
        plan.set_ylim(-40.0, 30.0)
        plan.set_aspect("equal", adjustable="box")
        plan.legend(loc="lower left", fontsize=7)
        plan.set_title("(a)")
        space = canvas.add_subplot(1, 2, 2, projection="3d")
        _in_space(space, runs[0], depth=(0.0, 15.0))
        space.set_title("(b)")

    return draw


def _space(depth: Limits) -> Draw:
    def draw(canvas: Canvas, runs: list[Run]) -> None:
        _in_space(canvas.add_subplot(projection="3d"), runs[0], depth=depth)

    return draw


def _tracks(axes: Any, run: Run, *, dimensions: int) -> None:
    path, _ = path_points_ned(run.recording, run.scenario)
    axes.plot(*path[:, 0, :dimensions].T, color="0.6", linewidth=3.0, alpha=0.6, label="desired, AUV1")
    for i in range(run.recording.n_vehicles):
        track = run.recording.position_ned_m[:, i, :dimensions]
        axes.plot(*track[::5].T, label=f"AUV{i + 1}", **vehicle_style(i))
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")


def _in_space(axes: Any, run: Run, *, depth: Limits) -> None:
    _tracks(axes, run, dimensions=3)
    axes.set_xlim(-40.0, 40.0)
    axes.set_ylim(-40.0, 40.0)
    axes.set_zlim(*depth)
    axes.set_zlabel("z (m, down is positive)")
    axes.legend(loc="upper left", fontsize=7)


def _position_errors(view: _View) -> Draw:
    def draw(canvas: Canvas, runs: list[Run]) -> None:
        axes, run = canvas.add_subplot(), runs[0]
        names = ("x error", "y error", "z error", "ψ error")
        _lines(axes, run.recording.t_s, errors(run.recording, run.scenario), names, view)
        axes.set_ylabel("path - AUV1 (m; ψ: rad)")

    return draw


def _velocity_errors(view: _View) -> Draw:
    def draw(canvas: Canvas, runs: list[Run]) -> None:
        axes, run = canvas.add_subplot(), runs[0]
        names = ("x rate", "y rate", "z rate", "ψ rate")
        _lines(axes, run.recording.t_s, rate_errors(run.recording, run.scenario), names, view)
        axes.set_ylabel("path - AUV1 (m/s; ψ: rad/s)")

    return draw


def _forces(view: _View) -> Draw:
    def draw(canvas: Canvas, runs: list[Run]) -> None:
        axes, recording = canvas.add_subplot(), runs[0].recording
        names = ("X (N)", "Y (N)", "Z (N)", "N (N m)")
        _lines(axes, recording.t_s, recording.command[:, 0][:, (0, 1, 2, 5)], names, view)
        axes.set_ylabel("force (N), moment (N m) of AUV1")

    return draw


def _distances(spans_s: tuple[Limits, Limits], values: tuple[Limits, Limits]) -> Draw:
    """Return the drawer of differences of radii beside distances of hulls, (a) d12, (b) d23."""

    def draw(canvas: Canvas, runs: list[Run]) -> None:
        recording = runs[0].recording
        pairs, position = signed_distances_m(recording), recording.position_ned_m
        for i, name in enumerate(("12", "23")):
            axes = canvas.add_subplot(1, 2, i + 1)
            true = np.linalg.norm(position[:, i + 1] - position[:, i], axis=-1)
            names = (f"d{name} = r{name[1]} - r{name[0]}", "between hull centres")
            view = _View(spans_s[i], values[i], (0.0, 25.0), (0.35, 0.3, 0.6, 0.42))
            _lines(axes, recording.t_s, np.column_stack([pairs[i], true]), names, view)
            axes.legend(loc="lower right", fontsize=7)
            axes.set_ylabel(f"distance AUV{name[0]} to AUV{name[1]} (m)")
            axes.set_title(f"({'ab'[i]})")

    return draw


def _difference(view: _View) -> Draw:
    def draw(canvas: Canvas, runs: list[Run]) -> None:
        axes, recording = canvas.add_subplot(), runs[0].recording
        d12, d23 = signed_distances_m(recording)
        _lines(axes, recording.t_s, (d12 - d23)[:, np.newaxis], ("d12 - d23",), view)
        axes.set_ylabel("d12 - d23 (m)")

    return draw


FIGURES = (
    Figure(
        "3.4",
        "Three vehicles on three circles",
        (CIRCLE,),
        _plan_and_space(),
        "In the thesis three vehicles converge to circles of 10, 20 and 30 m at a depth of 10 m; so do "
        "ours. The thesis does not print the starts; ours fit the axes of Figs 3.4-3.9.",
    ),
    Figure(
        "3.5",
        "Position errors of AUV1, circle",
        (CIRCLE,),
        _position_errors(_View((0.0, 100.0), (-2.0, 10.0), (0.0, 20.0))),
        "Path minus vehicle. All four axes are lightly damped (damping ratios of 0.05 to 0.08); drag, "
        "which grows with the square of the speed, damps the first oscillation.",
    ),
    Figure(
        "3.6",
        "Velocity errors of AUV1, circle",
        (CIRCLE,),
        _velocity_errors(_View((0.0, 100.0), (-7.0, 2.0), (0.0, 20.0), (0.3, 0.1, 0.5, 0.5))),
        "The thesis labels them u, v, w and r of the body. Ours are rates in NED, which are the same if J "
        "= I. The dive from 0 to 10 m exceeds 6 m/s.",
    ),
    Figure(
        "3.7",
        "Forces and moment of AUV1, circle",
        (CIRCLE,),
        _forces(_View((0.0, 200.0), (-2000.0, 10000.0), (50.0, 200.0))),
        "The peak is K_D Λ e(0) = 50 x 20 x 10 m = 10 kN on z, on a vehicle of 126.5 kg. The later forces "
        "are too small for this axis, but not zero (inset).",
    ),
    Figure(
        "3.8",
        "Distances on the circle",
        (CIRCLE,),
        _distances(((0.0, 200.0), (0.0, 300.0)), ((-4.0, 12.0), (-2.0, 12.0))),
        "The thesis's distances become negative, so they are differences of radii. The distances between "
        "hull centres are drawn beside them; they are the same once the vehicles lie on one ray.",
    ),
    Figure(
        "3.9",
        "Difference of the distances, circle",
        (CIRCLE,),
        _difference(_View((0.0, 300.0), (-3.5, 1.5), (0.0, 30.0), (0.3, 0.1, 0.6, 0.45))),
        "Zero at the resolution of this axis after 20 s, in the thesis and here; millimetres remain.",
    ),
    Figure(
        "3.10",
        "Three vehicles on three spirals",
        (SPIRAL,),
        _space((0.0, 2000.0)),
        "2000 m deep in 2000 s, as in the thesis. Starts fit the axes of Figs 3.11, 3.13 and 3.14.",
    ),
    Figure(
        "3.11",
        "Position errors of AUV1, spiral",
        (SPIRAL,),
        _position_errors(_View((0.0, 200.0), (-2.0, 10.0), (0.0, 20.0))),
        "As in the thesis, except for a steady depth error of 10 mm: the eight parameters have no linear "
        "drag.",
    ),
    Figure(
        "3.12",
        "Forces and moment of AUV1, spiral",
        (SPIRAL,),
        _forces(_View((0.0, 200.0), (-5000.0, 40000.0), (0.0, 20.0))),
        "The thesis's force reaches at least 35 kN, ours does not: errors in x and y are below 10 m, and z "
        "starts on its path. A numerically differentiated path whose rate in z jumps from 0 to 1 m/s "
        "within one step of 3.4 ms would give such a spike. This is a guess and is not modelled.",
    ),
    Figure(
        "3.13",
        "Distances on the spiral",
        (SPIRAL,),
        _distances(((0.0, 2000.0), (0.0, 2000.0)), ((0.0, 12.0), (0.0, 12.0))),
        "Differences of radii, and distances between hull centres, for 2000 s.",
    ),
    Figure(
        "3.14",
        "Difference of the distances, spiral",
        (SPIRAL,),
        _difference(_View((0.0, 2000.0), (-0.2, 1.2), (0.0, 30.0), (0.3, 0.4, 0.6, 0.5))),
        "The start fills the axis (inset); the rest is almost zero. Starts that fit are rare: a search on "
        "a grid of 0.5 m found none, a search on a grid of 0.1 m did.",
    ),
)
