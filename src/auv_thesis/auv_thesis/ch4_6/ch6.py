"""Chapter 6: flocking with fuzzy potentials, thesis Figs 6.3-6.9, Table 6.1 and its conclusions."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure as Canvas

from auv_experiment.figures.plotting import vehicle_style
from auv_flocking.mamdani import SETS, Peaks
from auv_thesis.ch4_6.ch5_claims import judge_potential
from auv_thesis.ch4_6.ch5_tables import NEAR_RATIO, flock_rows, marker_row, seconds, settled_m
from auv_thesis.ch4_6.flock_drawing import Limits, distance_panels, draw_distances, draw_tracks, legend_of
from auv_thesis.ch4_6.flock_runs import (
    FOUR_LEADERS,
    FUZZY_FOUR_LEADERS,
    FUZZY_OBSTACLES,
    FUZZY_ONE_LEADER,
    FUZZY_PRINTED_OBSTACLES,
    OBSTACLES,
    ONE_LEADER,
)
from auv_thesis.items import (
    AGREES,
    DIFFERS,
    DOES_NOT_HOLD,
    HOLDS,
    HOLDS_IN_PART,
    NO_NUMBER,
    Claim,
    Figure,
    Row,
    Run,
    Table,
    Verdict,
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


def _judge_nearer(runs: list[Run]) -> Verdict:
    spacing_m = runs[0].scenario.agent.flocking.params.spacing_m if runs[0].scenario.agent.flocking else 0.0
    worst = [max(abs(distance_m - spacing_m) for distance_m in settled_m(run)) for run in runs]
    evidence = (
        f"largest deviation from d = {spacing_m:g} m after 100 s: four leaders {worst[0]:.3f} m "
        f"mathematical, {worst[2]:.3f} m fuzzy; one leader {worst[1]:.3f} m and {worst[3]:.3f} m"
    )
    nearer = worst[2] < worst[0] and worst[3] < worst[1]
    return Verdict(HOLDS if nearer else DOES_NOT_HOLD, evidence)


def _judge_faster(runs: list[Run]) -> Verdict:
    times_s = [run.metrics["approach_time_2pct_s"] for run in runs]
    evidence = (
        f"from the same starts: four leaders {seconds(times_s[0])} mathematical, {seconds(times_s[2])} "
        f"fuzzy; one leader {seconds(times_s[1])} and {seconds(times_s[3])}. The thesis's own curves start "
        "differently: the fuzzy ones begin between 1.9 and 2 m"
    )
    if None in times_s:
        return Verdict(DOES_NOT_HOLD, evidence)
    faster = [fuzzy < mathematical for mathematical, fuzzy in zip(times_s[:2], times_s[2:], strict=True)]
    return Verdict(HOLDS if all(faster) else HOLDS_IN_PART if any(faster) else DOES_NOT_HOLD, evidence)


def _judge_limit(runs: list[Run]) -> Verdict:
    evidence = ", ".join(f"{settled_m(run)[0]:.4f} to {settled_m(run)[1]:.4f} m" for run in runs)
    exact = all(abs(distance_m - 2.0) < 1e-3 for run in runs for distance_m in settled_m(run))
    near = all(abs(distance_m - 2.0) < 0.1 for run in runs for distance_m in settled_m(run))
    return Verdict(
        HOLDS if exact else HOLDS_IN_PART if near else DOES_NOT_HOLD,
        f"after 100 s {evidence}; at d the fuzzy law does not repel, but attraction still acts",
    )


def _judge_obstacles(runs: list[Run]) -> Verdict:
    fuzzy, mathematical, printed = runs
    clear_m = fuzzy.metrics["obstacle_clearance_min_m"]
    evidence = (
        f"repelling only: no centre nearer than {clear_m:.3f} m to an obstacle (mathematical law: "
        f"{mathematical.metrics['obstacle_clearance_min_m']:.3f} m), no two nearer than "
        f"{fuzzy.metrics['pair_distance_min_m']:.3f} m; its repulsion is bounded, and the attraction of the "
        "flock pushes against it. As printed, obstacles attract at long range: the flock is "
        f"{printed.metrics['centroid_path_rms_m']:.2f} m off its path (rms)"
    )
    safe = clear_m > fuzzy.scenario.hull_radius_m and not fuzzy.metrics["collision"]
    return Verdict(HOLDS_IN_PART if safe else DOES_NOT_HOLD, evidence)


def _judge_flocking(runs: list[Run]) -> Verdict:
    collides = any(run.metrics["collision"] for run in runs)
    lags_m = [run.metrics["centroid_path_rms_m"] for run in runs]
    closest_m = min(run.metrics["pair_distance_min_m"] for run in runs)
    evidence = (
        f"centroid {lags_m[0]:.3f} m (four leaders) and {lags_m[1]:.3f} m (one leader, printed law) from the "
        f"path, rms, as with the mathematical law; no two centres nearer than {closest_m:.3f} m"
    )
    return Verdict(HOLDS if not collides and max(lags_m) < 0.2 else DOES_NOT_HOLD, evidence)


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

CLAIMS = (
    Claim("6.7", "The fuzzy law keeps distances nearer to d.", _ALL, _judge_nearer),
    Claim("6.7", "The fuzzy flock forms faster.", _ALL, _judge_faster),
    Claim("6.3", "Distances converge to d.", (FUZZY_FOUR_LEADERS, FUZZY_ONE_LEADER), _judge_limit),
    Claim(
        "6.6",
        "With the fuzzy law the vehicles flock along the path without collision.",
        (FUZZY_FOUR_LEADERS, FUZZY_ONE_LEADER),
        _judge_flocking,
    ),
    Claim(
        "6.6.3",
        "With the fuzzy law the flock passes the obstacles without collision.",
        (FUZZY_OBSTACLES, OBSTACLES, FUZZY_PRINTED_OBSTACLES),
        _judge_obstacles,
    ),
    Claim(
        "6.5",
        "By LaSalle's principle the flock's potential decreases until it is at rest.",
        (FOUR_LEADERS, FUZZY_FOUR_LEADERS, FUZZY_ONE_LEADER),
        judge_potential,
    ),
)
