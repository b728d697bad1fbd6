"""
Laws for a group in formation, thesis Sections 3.5.1 and 7.3; `formation_runs` has the laws and the runs.

Errors are those of the distances between neighbours, 10 m in thesis Eq. (3.2), after the first 30 s.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure as Canvas

from auv_experiment.figures.plotting import colour, legend_below, marker
from auv_thesis.cases import by_case
from auv_thesis.intervals import difference_bounds, difference_words, mean_words
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
from auv_thesis.laws.formation_runs import (
    ADAPTIVE,
    DISTURBANCES,
    FIXED,
    JUDGED_AFTER_S,
    LAWS,
    LIMITS,
    NOISE,
    NOISY,
    NOISY_LAWS,
    ROBUST,
    RUNS,
    SEEDS,
    SPACING_M,
    WITH_SPRINGS,
)

NOISE_SD_MM = 50.0
_JUDGEMENTS = (DOES_NOT_HOLD, HOLDS_IN_PART, HOLDS)


class FormationNumbers(NamedTuple):
    """Error of the distances of neighbours (mm), rms and worst, and rms force of a vehicle (N)."""

    rms_mm: float
    worst_mm: float
    effort_n: float


def numbers_of(run: Run) -> FormationNumbers:
    """Return the summary of one run, after its start."""
    t_s = run.recording.t_s
    steps_m = np.diff(run.recording.position_ned_m[t_s >= JUDGED_AFTER_S], axis=1)
    error_mm = 1e3 * (np.linalg.norm(steps_m, axis=-1) - SPACING_M)
    force_n = run.recording.command[t_s[:-1] >= JUDGED_AFTER_S][..., :3]
    return FormationNumbers(
        rms_mm=float(np.sqrt(np.square(error_mm).mean())),
        worst_mm=float(np.abs(error_mm).max()),
        effort_n=float(np.sqrt(np.square(force_n).sum(axis=-1).mean())),
    )


def _by_case(runs: list[Run]) -> dict[tuple[str, str], FormationNumbers]:
    return {case: numbers_of(run) for case, run in zip(RUNS, runs, strict=True)}


def _noisy_mm(runs: list[Run]) -> dict[str, list[float]]:
    """Return the rms errors of each law with noise, one per seed (mm)."""
    return by_case(NOISY_LAWS, [numbers_of(run).rms_mm for run in runs])


def _rows(runs: list[Run]) -> list[Row]:
    single, noisy = runs[: len(RUNS)], runs[len(RUNS) :]
    rows = [
        Row(
            f"{law}, {condition}",
            "not in the thesis",
            f"rms {each.rms_mm:.1f} mm, worst {each.worst_mm:.1f} mm, force {each.effort_n:.1f} N",
            NO_NUMBER,
        )
        for (law, condition), each in _by_case(single).items()
    ]
    for law, rms_mm in _noisy_mm(noisy).items():
        words = f"rms {mean_words(rms_mm, 'mm', 1)}, n = {len(rms_mm)}"
        rows.append(Row(f"{law}, {NOISE}", "not in the thesis", words, NO_NUMBER))
    return rows


def _draw(canvas: Canvas, runs: list[Run]) -> None:
    canvas.set_size_inches(6.5, 4.0)
    axes = canvas.subplots()
    results, noisy = _by_case(runs[: len(RUNS)]), _noisy_mm(runs[len(RUNS) :])
    conditions = [*dict.fromkeys(condition for _, condition in RUNS), NOISE]
    for i, law in enumerate(LAWS):
        rms_mm = [results[law, condition].rms_mm for condition in conditions[:-1]]
        places = np.arange(len(conditions)) + 0.12 * (i - 0.5 * (len(LAWS) - 1))
        axes.plot(
            places,
            np.maximum([*rms_mm, float(np.mean(noisy.get(law, np.nan)))], 1e-2),
            label=law,
            marker=marker(i),
            color=colour(i),
            linestyle="none",
            markersize=6,
        )
    axes.set_yscale("log")
    axes.set_ylabel("rms error of distances (mm)")
    axes.set_xticks(range(len(conditions)), conditions, rotation=15)
    legend_below(canvas, *axes.get_legend_handles_labels())


def _worst_mm(results: dict[tuple[str, str], FormationNumbers], law: str) -> float:
    return max(results[law, condition].rms_mm for condition in DISTURBANCES)


def _judge_robustness(runs: list[Run]) -> Verdict:
    """Judge without springs, which laws of the thesis could have as well."""
    results = _by_case(runs)
    rivals_mm = min(_worst_mm(results, law) for law in (FIXED, ADAPTIVE))
    better = sum(_worst_mm(results, law) < rivals_mm for law in ROBUST)
    words = ", ".join(f"{law} {_worst_mm(results, law):.1f} mm" for law in (FIXED, ADAPTIVE, *ROBUST))
    evidence = (
        f"largest rms error of the distances over {len(DISTURBANCES)} disturbances, one run each, no "
        f"springs, equal stiffness: {words}. Within its layer sliding mode is the fixed model; H-infinity "
        "has an integral, which removes a constant disturbance in any law"
    )
    return Verdict(_JUDGEMENTS[better], evidence)


def _judge_noise_and_limits(runs: list[Run]) -> Verdict:
    results, noisy = _by_case(runs[: len(RUNS)]), _noisy_mm(runs[len(RUNS) :])
    good = [max(*noisy[law], results[law, LIMITS].rms_mm) < NOISE_SD_MM for law in NOISY_LAWS]
    words = "; ".join(
        f"{law} {mean_words(noisy[law], 'mm', 1)} with noise, {results[law, LIMITS].rms_mm:.1f} mm with "
        "limits"
        for law in NOISY_LAWS
    )
    evidence = f"rms error of the distances, n = {len(SEEDS)} draws of the noise: {words}"
    return Verdict(_JUDGEMENTS[2 if all(good) else int(any(good))], f"{evidence}. The limit of 5 cm is ours")


def _judge_springs(runs: list[Run]) -> Verdict:
    results, noisy = _by_case(runs[: len(RUNS)]), _noisy_mm(runs[len(RUNS) :])
    wins, losses, parts = 0, 0, []
    for law, coupled in WITH_SPRINGS.items():
        ratios = [
            results[coupled, condition].rms_mm / results[law, condition].rms_mm for condition in DISTURBANCES
        ]
        low_mm, high_mm = difference_bounds(noisy[coupled], noisy[law])
        wins += (max(ratios) < 1.0) + (high_mm < 0.0)
        losses += (min(ratios) > 1.0) + (low_mm > 0.0)
        parts.append(
            f"{law}: {min(ratios):.2f} to {max(ratios):.2f} times the error under disturbances, one run "
            f"each, and {difference_words(noisy[coupled], noisy[law], 'mm', 1)} with noise (n = {len(SEEDS)})"
        )
    verdict = (
        HOLDS if not losses and wins == 2 * len(WITH_SPRINGS) else HOLDS_IN_PART if wins else DOES_NOT_HOLD
    )
    return Verdict(verdict, f"{'; '.join(parts)}. Springs pass on the noise of the neighbours' positions")


_ALL_RUNS = (*RUNS.values(), *NOISY.values())

FIGURES = (
    Figure(
        "7.C",
        "Laws for a group in formation under uncertainty and disturbances",
        _ALL_RUNS,
        _draw,
        "Not in the thesis. All laws are equally stiff. One run each; with noise the mean of ten. Errors "
        "below 0.01 mm are drawn there; sliding mode hides the fixed model, which it equals in its layer.",
    ),
)

TABLES = (Table("7.C", "Laws for three vehicles of Table 3.1 in formation", _ALL_RUNS, _rows),)

CLAIMS = (
    Claim(
        "7.3",
        "Sliding mode and H-infinity control keep a formation's distances consistent against the environment "
        "and uncertain hydrodynamics (the thesis proposes it; we compare with chapter 3 at equal stiffness).",
        tuple(RUNS.values()),
        _judge_robustness,
    ),
    Claim(
        "7.3",
        "In formation they tolerate measurement noise and actuator limits, with an rms error of the "
        "distances below the 5 cm of the noise.",
        _ALL_RUNS,
        _judge_noise_and_limits,
    ),
    Claim(
        "7.3",
        "A formation keeps its equal distances (3.2) better if neighbours are coupled (springs of ours).",
        _ALL_RUNS,
        _judge_springs,
    ),
)
