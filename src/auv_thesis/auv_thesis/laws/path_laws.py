"""
Every path-following law on one plant, thesis Section 7.3: the vehicle of Table 2.1, body frame, drag d_Q
|a| a.

A circle of 10 m at 0.1 m/s past an obstacle 0.57 m beside it, sampled at 10 Hz. Errors count after the first
50 s and where the path is more than 3 m away from the obstacle, so that avoidance does not count as an error.
Effort and distance are those of the whole run.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure as Canvas

from auv_experiment.figures.plotting import colour, legend_below, marker
from auv_experiment.metrics import path as metrics_path
from auv_experiment.metrics.distances import obstacle_distances_m
from auv_thesis.items import (
    DOES_NOT_HOLD,
    HOLDS,
    HOLDS_IN_PART,
    NO_NUMBER,
    Claim,
    Figure,
    Row,
    Run,
    RunSpec,
    Table,
    Verdict,
)

AFTER_S = 50.0
CLEAR_OF_OBSTACLE_M = 3.0
_INERTIA = (215.0, 265.0, 265.0, 80.0)
_LINEAR = (70.0, 100.0, 100.0, 50.0)
_QUADRATIC = (100.0, 200.0, 200.0, 100.0)


def _numbers(values: tuple[float, ...], factor: float = 1.0) -> str:
    return str([round(factor * value, 6) for value in values])


def _scaled_plant(factor: float) -> tuple[str, ...]:
    names = {"inertia": _INERTIA, "linear_damping": _LINEAR, "quadratic_damping": _QUADRATIC}
    return tuple(
        f"vehicles.0.model.params.{name}={_numbers(values, factor)}" for name, values in names.items()
    )


LAWS = {
    "PD (pfpd)": "{kind: pfpd}",
    "augmented PD (pfapd)": "{kind: pfapd}",
    "adaptive": (
        "{preset: adaptive_corrected, params: {"
        f"nominal_inertia: {_numbers(_INERTIA)}, nominal_linear_damping: {_numbers(_LINEAR)}, "
        f"nominal_quadratic_damping: {_numbers(_QUADRATIC)}}}}}"
    ),
    "sliding mode": "{kind: sliding_mode}",
    "H-infinity": "{preset: h_infinity_table_2_1}",
}
ROBUST = ("sliding mode", "H-infinity")
CONDITIONS: dict[str, tuple[str, ...]] = {
    "nominal": (),
    "plant +30 %": _scaled_plant(1.3),
    "plant -30 %": _scaled_plant(0.7),
    "current 0.1 m/s": ("environment.current_ned_mps=[0.1, 0.0, 0.0]",),
    "noise 5 cm, 1 cm/s": (
        "environment.navigation={kind: noisy, params: {position_sd_m: 0.05, velocity_sd_mps: 0.01}}",
    ),
    "limits 200 N": ("vehicles.0.model.params.max_force_n=200.0",),
}
CASES = [(law, condition) for law in LAWS for condition in CONDITIONS]
RUNS = tuple(
    RunSpec("compare_path_laws", (f"agent.controller={LAWS[law]}", *CONDITIONS[condition]))
    for law, condition in CASES
)


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


def _judge_robustness(runs: list[Run]) -> Verdict:
    results = _numbers_by_case(runs)
    tests = ("plant +30 %", "plant -30 %", "current 0.1 m/s")
    worst_mm = {law: 1e3 * max(results[law, condition].rms_m for condition in tests) for law in LAWS}
    others_mm = min(value for law, value in worst_mm.items() if law not in ROBUST)
    better = sum(worst_mm[law] < others_mm for law in ROBUST)
    evidence = "largest rms error over plant +-30 % and current: " + ", ".join(
        f"{law} {value:.1f} mm" for law, value in worst_mm.items()
    )
    return Verdict((DOES_NOT_HOLD, HOLDS_IN_PART, HOLDS)[better], evidence)


def _judge_noise_and_limits(runs: list[Run]) -> Verdict:
    results = _numbers_by_case(runs)
    tests = ("noise 5 cm, 1 cm/s", "limits 200 N")
    parts, good = [], 0
    for law in ROBUST:
        ratios = [
            results[law, condition].effort_n2s / results[law, "nominal"].effort_n2s for condition in tests
        ]
        rms_mm = [1e3 * results[law, condition].rms_m for condition in tests]
        good += max(rms_mm) < 50.0
        parts.append(
            f"{law}: {rms_mm[0]:.1f} mm and {ratios[0]:.2f} times the nominal effort with noise, "
            f"{rms_mm[1]:.1f} mm and {ratios[1]:.2f} times with limits"
        )
    return Verdict((DOES_NOT_HOLD, HOLDS_IN_PART, HOLDS)[good], "; ".join(parts))


FIGURES = (
    Figure(
        "7.A",
        "Path-following laws under uncertainty and disturbances",
        RUNS,
        _draw,
        "Not in the thesis. Upper panel: marks are rms errors, lines extend to the worst error (errors "
        "below 0.01 mm are drawn there). Lower panel: the effort of the whole run, which for the laws of "
        "chapter 2 is mostly the approach.",
    ),
)

TABLES = (Table("7.A", "Path-following laws on the vehicle of Table 2.1", RUNS, _rows),)

CLAIMS = (
    Claim(
        "7.3",
        "Sliding mode and H-infinity control keep results consistent against the environment and uncertain "
        "hydrodynamics (the thesis proposes it; we compare with its own laws).",
        RUNS,
        _judge_robustness,
    ),
    Claim(
        "7.3",
        "They tolerate measurement noise and actuator limits, with an rms error below the 5 cm of the noise.",
        RUNS,
        _judge_noise_and_limits,
    ),
)
