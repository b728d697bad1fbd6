"""Chapter 6: flocking with fuzzy potentials, thesis Figs 6.3-6.9 and Table 6.1."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure as Canvas

from auv_experiment.figures.plotting import vehicle_style
from auv_flocking.mamdani import SETS, Peaks
from auv_thesis.ch4_6.ch5_tables import NEAR_RATIO, flock_rows, marker_row, seconds, settled_m
from auv_thesis.ch4_6.flock_drawing import Limits, distance_panels, draw_distances, draw_tracks, legend_of
from auv_thesis.ch4_6.flock_runs import (
    FOUR_LEADERS,
    FUZZY_FOUR_LEADERS,
    FUZZY_OBSTACLES,
    FUZZY_ONE_LEADER,
    FUZZY_PRINTED_OBSTACLES,
    ONE_LEADER,
)
from auv_thesis.items import (
    AGREES,
    DIFFERS,
    NO_NUMBER,
    Figure,
    Row,
    Run,
    Table,
)

_WHOLE_S: Limits = (0.0, 700.0)
_WIDE: Limits = (-20.0, 20.0)
_SPACE = (_WIDE, _WIDE, (0.0, 12.0))
_ROUND: Limits = (-15.0, 15.0)
_NEAR_M: Limits = (1.9, 2.0)
_TIME_RATIO = 0.1

# Table 6.1: approach (s), smallest and largest distance (m).
_PRINTED = {
    "mathematical, four leaders": (2.9, 1.575, 1.616),
    "mathematical, one leader": (2.4, 1.584, 1.611),
    "fuzzy, four leaders": (1.4, 1.938, 1.981),
    "fuzzy, one leader": (1.2, 1.939, 1.978),
}
_ALL = (FOUR_LEADERS, ONE_LEADER, FUZZY_FOUR_LEADERS, FUZZY_ONE_LEADER)


def _draw_6_3(canvas: Canvas, runs: list[Run]) -> None:
    law: Any = runs[0].scenario.agent.separation
    panels = distance_panels(canvas, 3)
    canvas.set_size_inches(9.0, 3.4)
    of_input, of_output = law.params.input_peaks_m, law.params.output_peaks_mps
    inner_m = 2.0 * of_input[3]
    titles = ("(a) input", "(a) input, enlarged", "(b) output")
    for axes, title, peaks in zip(panels, titles, (of_input, of_input, of_output), strict=True):
        _draw_sets(axes, peaks)
        axes.set_title(title)
        axes.set_ylim(0.0, 1.05)
        axes.set_ylabel("membership")
    panels[0].set_xlim(-5.0, 5.0)
    panels[1].set_xlim(-inner_m, inner_m)
    panels[2].set_xlim(-2.0, 2.0)
    panels[0].set_xlabel("r - d (m)")
    panels[1].set_xlabel("r - d (m)")
    panels[2].set_xlabel("output (m/s)")
    legend_of(canvas, panels[0])


def _draw_sets(axes: Any, peaks: Peaks) -> None:
    """Draw the five triangular sets between neighbouring peaks."""
    for index, name in enumerate(SETS):
        heights = np.eye(len(SETS))[index]
        axes.plot(peaks, heights, label=name, **vehicle_style(index))


def _draw_tracks(canvas: Canvas, runs: list[Run]) -> None:
    draw_tracks(canvas, runs[0], _SPACE, ((-15.0, 20.0), _ROUND))


def _draw_6_8(canvas: Canvas, runs: list[Run]) -> None:
    draw_tracks(canvas, runs[0], _SPACE, (_ROUND, _ROUND))


def _draw_distances(canvas: Canvas, runs: list[Run]) -> None:
    whole, start = distance_panels(canvas, 2)
    draw_distances(whole, runs[0], _WHOLE_S, _NEAR_M)
    draw_distances(start, runs[0], (0.0, 2.0), _NEAR_M)
    legend_of(canvas, whole)


def _draw_6_9(canvas: Canvas, runs: list[Run]) -> None:
    (axes,) = distance_panels(canvas, 1)
    draw_distances(axes, runs[0], _WHOLE_S, (1.0, 8.0))
    legend_of(canvas, axes)


def _rows_6_1(runs: list[Run]) -> list[Row]:
    rows = []
    for (name, (printed_s, low_m, high_m)), run in zip(_PRINTED.items(), runs, strict=True):
        ours_s = run.metrics["approach_time_2pct_s"]
        near = ours_s is not None and abs(ours_s - printed_s) <= _TIME_RATIO * printed_s
        rows.append(
            Row(
                f"{name}: flocking approach time",
                f"{printed_s:g} s",
                seconds(ours_s),
                AGREES if near else DIFFERS,
                "ours: to 2 % of the final distances from starts 11 to 23 m apart; the thesis prints none",
            )
        )
        for word, printed_m, ours_m in zip(
            ("smallest", "largest"), (low_m, high_m), settled_m(run), strict=True
        ):
            near = abs(ours_m - printed_m) <= NEAR_RATIO * printed_m
            rows.append(
                Row(
                    f"{name}: {word} distance",
                    f"{printed_m:g} m",
                    f"{ours_m:.4f} m",
                    AGREES if near else DIFFERS,
                    f"{1e3 * (ours_m - printed_m):+.0f} mm; ours after 100 s",
                )
            )
    return rows


def _rows_6_a(runs: list[Run]) -> list[Row]:
    four, one, obstacles, printed = runs
    return [
        marker_row("distance marked in Fig. 6.5", 1.959, four),
        marker_row("distance marked in Fig. 6.7", 1.96, one),
        *flock_rows("four leaders", four),
        *flock_rows("one leader, printed followers", one),
        *flock_rows("obstacles that only repel", obstacles),
        Row(
            "obstacles that attract at long range, as printed: centroid to path, rms after 100 s",
            "not given",
            f"{printed.metrics['centroid_path_rms_m']:.2f} m in {printed.scenario.duration_s:g} s",
            NO_NUMBER,
            "the flock is drawn to the obstacles and leaves its path",
        ),
    ]


FIGURES = (
    Figure(
        "6.3",
        "Fuzzy sets, (a) of the input, (b) of the output",
        (FUZZY_FOUR_LEADERS,),
        _draw_6_3,
        "The thesis shows five triangles each on [-5, 5] and [-2, 2], tuned by trial, and prints no peaks. "
        "Our input peaks give its distances: the set of zero is 4.5 cm wide on each side and is also drawn "
        "enlarged.",
    ),
    Figure(
        "6.4",
        "Four leaders with the fuzzy law, (a) in space, (b) in the plane",
        (FUZZY_FOUR_LEADERS,),
        _draw_tracks,
        "Both flocks gather and go round together, as with the mathematical law.",
    ),
    Figure(
        "6.5",
        "Distances among four leaders with the fuzzy law, whole run and the first 2 s",
        (FUZZY_FOUR_LEADERS,),
        _draw_distances,
        "The thesis's distances vary between 1.938 and 1.981 m; ours settle at 1.959 m. The thesis's inset "
        "starts inside this window; from our starts the flock enters it later.",
    ),
    Figure(
        "6.6",
        "One leader and three followers with the fuzzy law, (a) in space, (b) in the plane",
        (FUZZY_ONE_LEADER,),
        _draw_tracks,
        "Both flocks gather and go round together. Followers are attracted to the path, as printed.",
    ),
    Figure(
        "6.7",
        "Distances among one leader and three followers with the fuzzy law, whole run and the first 2 s",
        (FUZZY_ONE_LEADER,),
        _draw_distances,
        "The thesis's distances vary between 1.939 and 1.978 m; ours stay within 3 mm of 1.9595 m.",
    ),
    Figure(
        "6.8",
        "One leader, three followers, two obstacles, fuzzy law, (a) in space, (b) in the plane",
        (FUZZY_OBSTACLES,),
        _draw_6_8,
        "Both flocks pass two obstacles. Ours are at (8, 5, 10) and (-9, -5, 10) m and only repel; as "
        "printed they would attract at long range.",
    ),
    Figure(
        "6.9",
        "Distances while the flock passes obstacles with the fuzzy law",
        (FUZZY_OBSTACLES,),
        _draw_6_9,
        "Both flocks keep their distances except for two disturbances at the obstacles.",
    ),
)

TABLES = (
    Table("6.1", "Approach times and distances, mathematical and fuzzy", _ALL, _rows_6_1),
    Table(
        "6.A",
        "Flocks with fuzzy potentials, continuous in time",
        (FUZZY_FOUR_LEADERS, FUZZY_ONE_LEADER, FUZZY_OBSTACLES, FUZZY_PRINTED_OBSTACLES),
        _rows_6_a,
    ),
)
