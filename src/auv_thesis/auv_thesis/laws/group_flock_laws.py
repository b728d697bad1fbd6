"""
Laws of thesis Section 7.3 for a group that flocks: sliding mode and H-infinity under the flocking law, and
adaptive fuzzy separation past an obstacle; `group_flock_runs` has the runs.
"""

from __future__ import annotations

from collections.abc import Sequence

from auv_thesis.cases import by_case
from auv_thesis.intervals import difference_bounds, difference_words, mean_words
from auv_thesis.items import (
    DOES_NOT_HOLD,
    HOLDS,
    HOLDS_IN_PART,
    NO_NUMBER,
    Claim,
    Row,
    Run,
    RunSpec,
    Table,
    Verdict,
)
from auv_thesis.laws.group_flock_runs import (
    DRAWN,
    LEARNING,
    PAST,
    PI,
    ROBUST,
    RUNS,
    SAFETY_M,
)
from auv_thesis.laws.separation_laws import deviation_m, distance_numbers

Case = tuple[str, str]


def _specs(cases: dict[Case, tuple[RunSpec, ...]]) -> tuple[RunSpec, ...]:
    return tuple(spec for specs in cases.values() for spec in specs)


def _worst_m(runs: Sequence[Run]) -> list[float]:
    return [deviation_m(run) for run in runs]


def _clearance_m(runs: Sequence[Run]) -> list[float]:
    return [float(run.metrics["obstacle_clearance_min_m"]) for run in runs]


def _controller_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for (controller, condition), run in zip(RUNS, runs[: len(RUNS)], strict=True):
        found = distance_numbers(run)
        words = (
            f"rms {found['rms_m']:.4f} m, worst {found['worst_m']:.3f} m, force {found['effort_n']:.1f} N, "
            f"smallest {found['smallest_m']:.2f} m"
        )
        rows.append(Row(f"{condition}: {controller}", "not in the thesis", words, NO_NUMBER))
    for (controller, condition), drawn in by_case(DRAWN, runs[len(RUNS) :]).items():
        words = f"worst {mean_words(_worst_m(drawn), 'm', 3)}, n = {len(drawn)}"
        rows.append(Row(f"{condition}: {controller}, drawn", "not in the thesis", words, NO_NUMBER))
    return rows


def _obstacle_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for (law, condition), drawn in by_case(PAST, runs).items():
        pairs_m = min(float(run.metrics["pair_distance_min_m"]) for run in drawn)
        words = (
            f"smallest distance to the obstacle {mean_words(_clearance_m(drawn), 'm')}, least "
            f"{min(_clearance_m(drawn)):.2f} m; least of pairs {pairs_m:.2f} m; n = {len(drawn)}"
        )
        note = "collision" if any(run.metrics["collision"] for run in drawn) else ""
        rows.append(Row(f"{condition}: {law}", "not in the thesis", words, NO_NUMBER, note))
    return rows


def _judge_controllers(runs: list[Run]) -> Verdict:
    """Judge by the largest error of a distance with noise, paired draw by draw with PI."""
    found = {controller: _worst_m(drawn) for (controller, _), drawn in by_case(DRAWN, runs).items()}
    better = sum(difference_bounds(found[law], found[PI])[1] < 0.0 for law in ROBUST)
    words = "; ".join(f"{law} {difference_words(found[law], found[PI], 'm', 4)}" for law in ROBUST)
    evidence = (
        f"worst error of a distance with noise, minus that with PI, n = {len(found[PI])} draws, equal "
        f"bandwidth: {words}. With PI it is {mean_words(found[PI], 'm', 3)}: separation and the age of "
        "information set it"
    )
    return Verdict((DOES_NOT_HOLD, HOLDS_IN_PART, HOLDS)[better], evidence)


def _judge_obstacles(runs: list[Run]) -> Verdict:
    found = {law: _clearance_m(drawn) for (law, _), drawn in by_case(PAST, runs).items()}
    learning = found[LEARNING]
    rivals = [law for law in found if law != LEARNING]
    is_farther = all(difference_bounds(learning, found[law])[0] > 0.0 for law in rivals)
    words = "; ".join(
        f"{mean_words(found[law], 'm')} with {law}, paired {difference_words(learning, found[law], 'm')}"
        for law in rivals
    )
    evidence = (
        f"smallest distance to an obstacle whose safety distance is {SAFETY_M:g} m, with noise, n = "
        f"{len(learning)} draws: {mean_words(learning, 'm')}, least {min(learning):.2f} m; {words}. The "
        f"peaks take seconds to learn, so that vehicles come nearer than {SAFETY_M:g} m. A wider safety "
        "distance would do without learning, but must be known in advance"
    )
    keeps = min(learning) >= SAFETY_M
    return Verdict(
        HOLDS if is_farther and keeps else HOLDS_IN_PART if is_farther else DOES_NOT_HOLD, evidence
    )


TABLES = (
    Table(
        "7.D",
        "Controllers under one flocking law, under disturbances",
        (*RUNS.values(), *_specs(DRAWN)),
        _controller_rows,
    ),
    Table("7.E", "Separation laws in a flock that passes an obstacle", _specs(PAST), _obstacle_rows),
)

CLAIMS = (
    Claim(
        "7.3",
        "Sliding mode and H-infinity control keep a flock's distances more consistent (the thesis proposes "
        "it; we compare with PI at equal bandwidth).",
        _specs(DRAWN),
        _judge_controllers,
    ),
    Claim(
        "7.3",
        "An adaptive fuzzy law keeps a flock at the safety distance of obstacles (the law is ours; we "
        "compare with the adaptive law that learns from vehicles only).",
        _specs(PAST),
        _judge_obstacles,
    ),
)
