"""Figures 2.6-2.18: the runs of chapter 2 with the thesis's settings, on the thesis's axes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from auv_experiment.figures.plotting import colour, plot_thinned, vehicle_style
from auv_experiment.recording import FloatArray
from auv_thesis.ch2.runs import (
    APD,
    APD_OBSTACLES,
    APD_ONE_OBSTACLE,
    PD,
    PD_OBSTACLES,
    PD_ONE_OBSTACLE,
    Curves,
    curves,
)
from auv_thesis.items import Figure, Run

Limits = tuple[float, float]
Panel = Callable[[Any, Run], None]
_POSES = ("x", "y", "ψ")
_RATES = ("u", "v", "r")
_WHOLE: Limits = (0.0, 600.0)
_POSE_LABEL = "x, y (m), ψ (rad)"
_RATE_LABEL = "u, v (m/s), r (rad/s)"


@dataclass(frozen=True)
class _Window:
    """Axis limits of one window of a figure: time (s) and values."""

    t_s: Limits
    values: Limits


@dataclass(frozen=True)
class _Inset(_Window):
    """A window within another one; `bottom` and `height` are fractions of the outer window's height."""

    bottom: float = 0.3
    height: float = 0.5


def _plan(x_m: Limits, y_m: Limits) -> Panel:
    """Return a panel of the track with x to the right and y up, as the thesis draws it."""

    def draw(axes: Any, run: Run) -> None:
        track = curves(run)
        axes.plot(track.path[:, 0], track.path[:, 1], color="0.6", linewidth=3.0, alpha=0.6, label="path")
        axes.plot(track.pose[:, 0], track.pose[:, 1], color="black", label="vehicle")
        for number, obstacle in enumerate(run.scenario.environment.obstacles, 1):
            x, y, _ = obstacle.position_ned_m
            reach = Circle((x, y), obstacle.safety_distance_m, facecolor="0.95", edgecolor="0.5", zorder=0)
            reach.set_linestyle("dashed")
            axes.add_patch(reach)
            axes.plot(x, y, "x", color="black", markeredgewidth=1.6)
            axes.annotate(
                f"obstacle {number}", (x, y), xytext=(3, -11), textcoords="offset points", fontsize=7
            )
        axes.set_xlim(*x_m)
        axes.set_ylim(*y_m)
        axes.set_aspect("equal", adjustable="box")
        axes.set_xlabel("x, x_r (m)")
        axes.set_ylabel("y, y_r (m)")
        axes.legend(loc="center", fontsize=7)

    return draw


def _pose(values: Limits) -> Panel:
    return _pairs(_POSES, lambda c: (c.path, c.pose), values, _POSE_LABEL)


def _rates(values: Limits) -> Panel:
    return _pairs(_RATES, lambda c: (c.path_velocity, c.velocity), values, _RATE_LABEL)


def _pairs(
    names: tuple[str, ...],
    choose: Callable[[Curves], tuple[FloatArray, FloatArray]],
    values: Limits,
    label: str,
) -> Panel:
    """Return a panel of vehicle and path, component by component, over the whole run."""

    def draw(axes: Any, run: Run) -> None:
        c = curves(run)
        wanted, flown = choose(c)
        for i, name in enumerate(names):
            plot_thinned(axes, c.t_s, wanted[:, i], color=colour(i), linewidth=3.0, alpha=0.3)
            plot_thinned(axes, c.t_s, flown[:, i], label=name, **vehicle_style(i))
        handles, _ = axes.get_legend_handles_labels()
        handles.append(Line2D([], [], color="0.4", linewidth=3.0, alpha=0.4, label="path"))
        axes.legend(handles=handles, loc="upper right", ncols=2, fontsize=7)
        _limit(axes, _Window(_WHOLE, values), dict(zip(names, flown.T, strict=True)), c.t_s)
        axes.set_xlabel("t (s)")
        axes.set_ylabel(label)

    return draw


def _pose_errors(main: _Window, inset: _Inset | None = None) -> Panel:
    return _errors(_POSES, lambda c: c.pose_error, "error (m; ψ: rad)", main, inset)


def _rate_errors(main: _Window, inset: _Inset | None = None) -> Panel:
    return _errors(_RATES, lambda c: c.velocity_error, "error (m/s; r: rad/s)", main, inset)


def _errors(
    names: tuple[str, ...],
    choose: Callable[[Curves], FloatArray],
    label: str,
    main: _Window,
    inset: _Inset | None,
) -> Panel:
    """Return a panel of errors, with an inset if the thesis has one."""

    def draw(axes: Any, run: Run) -> None:
        c = curves(run)
        lines = {f"{name}_e": values for name, values in zip(names, choose(c).T, strict=True)}
        _plot_lines(axes, c.t_s, lines, main, label, inset)

    return draw


def _plot_lines(
    axes: Any,
    t_s: FloatArray,
    lines: dict[str, FloatArray],
    main: _Window,
    label: str,
    inset: _Inset | None,
) -> Any | None:
    """Plot named lines into a window and into its inset; return the inset's axes."""
    for i, (name, values) in enumerate(lines.items()):
        plot_thinned(axes, t_s, values, label=name, **vehicle_style(i))
    _limit(axes, main, lines, t_s)
    axes.set_xlabel("t (s)")
    axes.set_ylabel(label)
    axes.legend(loc="upper right", ncols=len(lines), fontsize=7)
    if inset is None:
        return None
    small = axes.inset_axes((0.32, inset.bottom, 0.65, inset.height))
    for i, values in enumerate(lines.values()):
        shown = (t_s >= inset.t_s[0]) & (t_s <= inset.t_s[1])
        plot_thinned(small, t_s[shown], values[shown], **vehicle_style(i))
    small.set_xlim(*inset.t_s)
    small.set_ylim(*inset.values)
    small.tick_params(labelsize=7)
    return small


def _limit(axes: Any, window: _Window, lines: dict[str, FloatArray], t_s: FloatArray) -> None:
    """Set the thesis's limits, and name below the axes the lines that exceed them, and by how much."""
    axes.set_xlim(*window.t_s)
    axes.set_ylim(*window.values)
    low, high = window.values
    shown = (t_s >= window.t_s[0]) & (t_s <= window.t_s[1])
    beyond = []
    for name, values in lines.items():
        least, most = float(values[shown].min()), float(values[shown].max())
        slack = 0.01 * (high - low)
        leaving = [extreme for extreme in (least, most) if not low - slack <= extreme <= high + slack]
        beyond += [f"{name} to {extreme:.2f}" for extreme in leaving]
    if beyond:
        text = "beyond the thesis's axes: " + ", ".join(beyond)
        axes.set_title(text, fontsize=7, color="0.3", loc="right", pad=3)


def _figure(*panels: Panel) -> Callable[[Canvas, list[Run]], None]:
    """Return the drawing function of a figure: one panel, two side by side, or one beside two."""

    def draw(canvas: Canvas, runs: list[Run]) -> None:
        canvas.set_layout_engine("constrained")
        if len(panels) == 1:
            canvas.set_size_inches(6.5, 3.6)
            every = [canvas.add_subplot()]
        elif len(panels) == 2:
            canvas.set_size_inches(8.0, 3.8)
            every = list(canvas.subplots(1, 2))
        else:
            canvas.set_size_inches(8.6, 4.6)
            mosaic: Any = canvas.subplot_mosaic([["a", "b"], ["a", "c"]])
            every = [mosaic["a"], mosaic["b"], mosaic["c"]]
        for letter, axes, panel in zip("abc", every, panels, strict=False):
            panel(axes, runs[0])
            if len(panels) > 1:
                axes.set_title(f"({letter})", loc="left")

    return draw


def _draw_comparison(canvas: Canvas, runs: list[Run]) -> None:
    """Draw Fig. 2.18 with its inset and the instants at which the thesis reads its Table 2.2."""
    canvas.set_layout_engine("constrained")
    canvas.set_size_inches(7.5, 4.8)
    plain, augmented = curves(runs[0]), curves(runs[1])
    lines = {
        "x_e, PD": plain.pose_error[:, 0],
        "y_e, PD": plain.pose_error[:, 1],
        "x_e, APD": augmented.pose_error[:, 0],
        "y_e, APD": augmented.pose_error[:, 1],
    }
    axes = canvas.add_subplot()
    window, inset = _Window(_WHOLE, (-2.0, 10.0)), _Inset((0.0, 35.0), (-0.1, 0.6), 0.28, 0.56)
    small = _plot_lines(axes, plain.t_s, lines, window, "error (m)", inset)
    if small is None:
        return
    for pair in zip(*(_read(run) for run in runs), strict=True):
        highest = max(value_m for _, value_m in pair)
        for mark, (t_s, value_m) in zip("os", pair, strict=True):
            small.plot(t_s, value_m, mark, color="black", markerfacecolor="white", markersize=4)
            small.annotate(
                f"{value_m:.4f}",
                (t_s, value_m),
                xytext=(0, 7 if value_m == highest else -14),
                textcoords="offset points",
                ha="right" if t_s > 30.0 else "left",
                fontsize=6.5,
            )


def _read(run: Run) -> list[tuple[float, float]]:
    """Return the instants (s) and values (m) at which the thesis reads a run."""
    return [(reading.time_s, run.metrics[reading.key]) for reading in run.scenario.readings]


FIGURES = (
    Figure(
        "2.6",
        "PD on a circle: track and position",
        (PD,),
        _figure(_plan((-15.0, 15.0), (-15.0, 15.0)), _pose((-15.0, 15.0))),
        "Thesis: the vehicle comes from the origin and then lies on the circle. Ours: the same track. No "
        "term controls the heading, so the coupling of surge and sway makes it drift.",
    ),
    Figure(
        "2.7",
        "PD on a circle: position errors",
        (PD,),
        _figure(_pose_errors(_Window(_WHOLE, (-2.0, 10.0)), _Inset((0.0, 150.0), (-1.5, 1.5), 0.38, 0.48))),
        "Thesis: the errors go to zero after about 10 s. Ours: x and y come near zero in that time and "
        "then oscillate, once per round, with an amplitude of drag over gain; the heading error stays "
        "large. Inset as in the thesis.",
    ),
    Figure(
        "2.8",
        "PD on a circle: velocity errors",
        (PD,),
        _figure(_rate_errors(_Window(_WHOLE, (-2.5, 0.5)), _Inset((0.0, 70.0), (-0.2, 0.2), 0.22, 0.5))),
        "Thesis: zero after about 22 s, with a peak beyond -2 m/s across. Ours: the same, peak included.",
    ),
    Figure(
        "2.9",
        "PD past one obstacle: track and position",
        (PD_ONE_OBSTACLE,),
        _figure(_plan((-15.0, 15.0), (-15.0, 15.0)), _pose((-15.0, 15.0))),
        "Thesis: the vehicle avoids one obstacle and returns to the path. Ours: the same, by a few "
        "decimetres. The thesis does not say which obstacle it used; this is its first one, at (8, 5).",
    ),
    Figure(
        "2.10",
        "PD past two obstacles: track, position, velocity",
        (PD_OBSTACLES,),
        _figure(_plan((-10.0, 15.0), (-10.0, 15.0)), _pose((-10.0, 15.0)), _rates((-1.0, 1.5))),
        "Thesis: both obstacles are passed, positions and velocities match. Ours: the same after the "
        "start, where the sway velocity exceeds the axes of this figure.",
    ),
    Figure(
        "2.11",
        "PD past two obstacles: position and velocity errors",
        (PD_OBSTACLES,),
        _figure(_pose_errors(_Window(_WHOLE, (-2.0, 2.0))), _rate_errors(_Window(_WHOLE, (-1.0, 0.6)))),
        "Thesis: zero in about 23 s and 25 s except at the obstacles. Ours: the same after the start, "
        "which is 10 m off the path and beyond the thesis's axes; the thesis's own Fig. 2.18 shows the 10 "
        "m as well.",
    ),
    Figure(
        "2.12",
        "Augmented PD on a circle: track, position, velocity",
        (APD,),
        _figure(_plan((-10.0, 10.0), (-10.0, 15.0)), _pose((-10.0, 15.0)), _rates((-0.2, 1.6))),
        "Thesis: track, position and velocity match their references after about 10 s. Ours: the same. Our "
        "velocity peak exceeds the thesis's axis.",
    ),
    Figure(
        "2.13",
        "Augmented PD on a circle: position errors",
        (APD,),
        _figure(_pose_errors(_Window(_WHOLE, (-0.5, 2.0)), _Inset((0.0, 150.0), (-0.5, 1.0), 0.3, 0.34))),
        "Thesis: zero after about 10 s, on an axis that ends at 2 m. Ours: x and y go to zero and stay "
        "there; y starts at 10 m, as in the thesis's own Figs 2.17 and 2.18.",
    ),
    Figure(
        "2.14",
        "Augmented PD on a circle: velocity errors",
        (APD,),
        _figure(_rate_errors(_Window(_WHOLE, (-1.6, 0.2)), _Inset((0.0, 100.0), (-0.5, 0.1), 0.28, 0.48))),
        "Thesis: zero in about 22 s, on an axis that ends at -1.6 m/s. Ours: zero in that time; the sway "
        "peak is larger, which suggests that the thesis used lower gains than it prints, or another start.",
    ),
    Figure(
        "2.15",
        "Augmented PD past one obstacle: track, position, velocity",
        (APD_ONE_OBSTACLE,),
        _figure(_plan((-10.0, 15.0), (-10.0, 10.0)), _pose((-10.0, 15.0)), _rates((-0.4, 1.6))),
        "Thesis: the vehicle avoids one obstacle and returns to the path. Ours: the same.",
    ),
    Figure(
        "2.16",
        "Augmented PD past two obstacles: track, position, velocity",
        (APD_OBSTACLES,),
        _figure(_plan((-10.0, 15.0), (-10.0, 10.0)), _pose((-10.0, 15.0)), _rates((-1.0, 1.5))),
        "Thesis: both obstacles are passed, positions and velocities match. Ours: the same.",
    ),
    Figure(
        "2.17",
        "Augmented PD past two obstacles: position and velocity errors",
        (APD_OBSTACLES,),
        _figure(_pose_errors(_Window(_WHOLE, (-2.0, 10.0))), _rate_errors(_Window(_WHOLE, (-1.5, 0.5)))),
        "Thesis: zero in about 23 s and 25 s, with visible errors at the obstacles. Ours: earlier, with "
        "the same two disturbances; the heading error does not go to zero.",
    ),
    Figure(
        "2.18",
        "Position errors of both laws",
        (PD, APD),
        _draw_comparison,
        "Table 2.2 of the thesis has the values at the marked instants (circles: PD, squares: augmented "
        "PD). Our runs give the three readings of PD to every digit, but not those of the augmented law.",
    ),
)
