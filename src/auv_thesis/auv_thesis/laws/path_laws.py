"""
Every path-following law on one plant, thesis Section 7.3; `path_runs` has the laws, their gains and the runs.

Errors count after the first 50 s and where the path is more than 3 m away from the obstacle, so that
avoidance does not count as an error. Effort and distance are those of the whole run.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure as Canvas

from auv_experiment.figures.plotting import colour, legend_below, marker
from auv_experiment.metrics import path as metrics_path
from auv_experiment.metrics.distances import obstacle_distances_m
from auv_thesis.cases import by_case
from auv_thesis.intervals import mean_words
from auv_thesis.items import (
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
from auv_thesis.laws.path_runs import (
    ALL_LAWS,
    CASES,
    CONDITIONS,
    GAINS,
    LAWS,
    LIMITS,
    NOISY,
    NOISY_LAWS,
    RIVALS,
    ROBUST,
    RUNS,
    SEEDS,
)

NOISE_SD_M = 0.05
_CLEARLY = 0.95
"""A law is better if its error is at most this share of the other's."""
AFTER_S = 50.0
CLEAR_OF_OBSTACLE_M = 3.0


class LawNumbers(NamedTuple):
    """Errors (m) after the start and clear of the obstacle, effort (N^2 s), distance to the obstacle (m)."""

    rms_m: float
    worst_m: float
    effort_n2s: float
    clearance_m: float


def numbers_of(run: Run) -> LawNumbers:
    """Return the summary of one run."""
    recording, scenario = run.recording, run.scenario
    errors_m = np.linalg.norm(metrics_path.position_error_ned_m(recording, scenario)[:, 0], axis=-1)
    path_m = metrics_path.path_points_ned(recording, scenario)[0][:, 0]
    obstacle_m = np.asarray(scenario.environment.obstacles[0].position_ned_m)
    is_clear = np.linalg.norm((path_m - obstacle_m)[:, :2], axis=-1) > CLEAR_OF_OBSTACLE_M
    shown_m = errors_m[is_clear & (recording.t_s >= AFTER_S)]
    limit_n = scenario.vehicles[0].model.params.max_force_n
    forces_n = recording.command[:, 0, :3]
    given_n = forces_n if limit_n is None else np.clip(forces_n, -limit_n, limit_n)
    return LawNumbers(
        rms_m=float(np.sqrt(np.mean(shown_m**2))),
        worst_m=float(shown_m.max()),
        effort_n2s=float(np.sum(given_n**2) * scenario.period_s),
        clearance_m=float(np.nanmin(obstacle_distances_m(recording, scenario))),
    )


def _numbers_by_case(runs: list[Run]) -> dict[tuple[str, str], LawNumbers]:
    return {case: numbers_of(run) for case, run in zip(CASES, runs, strict=True)}


def _rows(runs: list[Run]) -> list[Row]:
    rows = []
    for (law, condition), result in _numbers_by_case(runs).items():
        ours = (
            f"rms {1e3 * result.rms_m:.1f} mm, worst {1e3 * result.worst_m:.1f} mm, "
            f"effort {result.effort_n2s:.3g} N^2 s, obstacle {result.clearance_m:.2f} m"
        )
        rows.append(Row(f"{law}, {condition}", "not in the thesis", ours, NO_NUMBER))
    return rows


def _draw(canvas: Canvas, runs: list[Run]) -> None:
    canvas.set_size_inches(6.5, 4.6)
    results = _numbers_by_case(runs)
    upper, lower = canvas.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    places = np.arange(len(CONDITIONS))
    for i, law in enumerate(LAWS):
        own = [results[law, condition] for condition in CONDITIONS]
        shift = 0.13 * (i - 0.5 * (len(LAWS) - 1))
        style: dict[str, Any] = {
            "marker": marker(i),
            "color": colour(i),
            "linestyle": "none",
            "markersize": 6,
        }
        upper.plot(places + shift, [1e3 * max(one.rms_m, 1e-5) for one in own], label=law, **style)
        upper.vlines(
            places + shift,
            [1e3 * max(one.rms_m, 1e-5) for one in own],
            [1e3 * max(one.worst_m, 1e-5) for one in own],
            color=colour(i),
            linewidth=1.0,
        )
        lower.plot(places + shift, [one.effort_n2s for one in own], **style)
    for axes, words in ((upper, "error (mm)"), (lower, "effort (N² s)")):
        axes.set_yscale("log")
        axes.set_ylabel(words)
    lower.set_xticks(places, list(CONDITIONS), rotation=12)
    legend_below(canvas, *upper.get_legend_handles_labels())


def _worst_mm(results: dict[tuple[str, str], LawNumbers], law: str) -> float:
    """Return the largest rms error over the disturbances that draw nothing (mm)."""
    tests = ("plant +30 %", "plant -30 %", "current 0.1 m/s")
    return 1e3 * max(results[law, condition].rms_m for condition in tests)


def _judge_robustness(runs: list[Run]) -> Verdict:
    """Judge against laws of the thesis that are as stiff: a stiffer law of any kind has smaller errors."""
    results = _numbers_by_case(runs)
    worst_mm = {law: _worst_mm(results, law) for law in ALL_LAWS}
    better = sum(worst_mm[law] < _CLEARLY * min(worst_mm[rival] for rival in RIVALS[law]) for law in ROBUST)
    words = ", ".join(
        f"{law} {value:.1f} mm" + (f" ({GAINS[law].stiffness_npm[0]:.0f} N/m)" if law in GAINS else "")
        for law, value in worst_mm.items()
    )
    evidence = f"largest rms error over plant +-30 % and current, one run each, stiffness in surge: {words}"
    return Verdict(
        (DOES_NOT_HOLD, HOLDS_IN_PART, HOLDS)[better],
        f"{evidence}. H-infinity has an integral, which removes a constant disturbance in any law",
    )


def _judge_noise_and_limits(runs: list[Run]) -> Verdict:
    results = _numbers_by_case(runs[: len(CASES)])
    noisy = by_case(NOISY_LAWS, [numbers_of(run) for run in runs[len(CASES) :]])
    parts, good = [], 0
    for law in NOISY_LAWS:
        rms_mm = [1e3 * one.rms_m for one in noisy[law]]
        ratios = [one.effort_n2s / results[law, "nominal"].effort_n2s for one in noisy[law]]
        limited_mm = 1e3 * results[law, LIMITS].rms_m
        if law in ROBUST:
            good += max(*rms_mm, limited_mm) < 1e3 * NOISE_SD_M
        parts.append(
            f"{law}: {mean_words(rms_mm, 'mm', 1)} and {mean_words(ratios, 'times the nominal effort')} with "
            f"noise, {limited_mm:.1f} mm with limits"
        )
    evidence = f"n = {len(SEEDS)} draws of the noise; {'; '.join(parts)}. The limit of 5 cm is ours"
    return Verdict((DOES_NOT_HOLD, HOLDS_IN_PART, HOLDS)[good], evidence)


FIGURES = (
    Figure(
        "7.A",
        "Path-following laws under uncertainty and disturbances",
        RUNS,
        _draw,
        "Not in the thesis. Each law with its own gains, one run each. Upper panel: marks are rms errors, "
        "lines extend to the worst error (errors below 0.01 mm are drawn there). Lower panel: the effort of "
        "the whole run, which for the laws of chapter 2 is mostly the approach.",
    ),
)

TABLES = (Table("7.A", "Path-following laws on the vehicle of Table 2.1", RUNS, _rows),)

CLAIMS = (
    Claim(
        "7.3",
        "Sliding mode and H-infinity control keep results consistent against the environment and uncertain "
        "hydrodynamics (the thesis proposes it; we compare with its own laws at equal stiffness).",
        RUNS,
        _judge_robustness,
    ),
    Claim(
        "7.3",
        "They tolerate measurement noise and actuator limits, with an rms error below the 5 cm of the noise.",
        (*RUNS, *(spec for specs in NOISY.values() for spec in specs)),
        _judge_noise_and_limits,
    ),
)
