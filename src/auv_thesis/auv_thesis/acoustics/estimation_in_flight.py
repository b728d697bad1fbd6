"""
Whether the filter's stated errors are as large as the real ones in flight, by the age of the information.

Table A.32 judges the filter on its own model of motion. Here the truth is the flock of the main job, which
turns, gathers and brakes as no filter's model does. A consistent filter has 5 % of its errors beyond its 95 %
ellipsoid and 0.3 % beyond its 99.7 % ellipsoid, at every age.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

from auv_experiment.recording import FloatArray
from auv_thesis.acoustics.estimation_runs import (
    DRIFT,
    DURATION_S,
    EVERY_TICKS,
    FORMED_S,
    relative_errors,
    spec_of,
)
from auv_thesis.intervals import mean_bounds
from auv_thesis.items import DOES_NOT_HOLD, HOLDS, HOLDS_IN_PART, NO_NUMBER, Claim, Row, Run, Table, Verdict

SEEDS = tuple(range(341, 349))
_SLOT_S, _LOSS = 0.5, 0.3
CASES = {"exact navigation": (), "navigations that drift": (DRIFT,)}
RUNS = {
    name: tuple(spec_of(_SLOT_S, _LOSS, *changes, seed=seed) for seed in SEEDS)
    for name, changes in CASES.items()
}
LEVELS = (0.95, 0.997)
AGES_S = (0.0, 2.0, 4.0, 8.0, np.inf)
PHASES = {"gathering": (0.0, FORMED_S), "formed": (FORMED_S, DURATION_S)}
_NUMBERS = 3


class Squares(NamedTuple):
    """Normalised squared errors (M,) of one run, with time (s) and age of the information (s) of each."""

    t_s: FloatArray
    age_s: FloatArray
    square: FloatArray


def squares_of(run: Run) -> Squares:
    """Return the normalised squared errors of all relative positions of a run, every half second."""
    relative = relative_errors(run)
    age_s = run.recording.neighbour_age_s[: len(run.recording.t_s) - 1][::EVERY_TICKS]
    known = np.isfinite(relative.errors_m).all(axis=-1) & np.isfinite(age_s)
    errors_m, covariance = relative.errors_m[known], relative.covariance[known]
    solved = np.linalg.solve(covariance, errors_m[..., None])[..., 0]
    t_s = np.broadcast_to(relative.t_s[:, None, None], known.shape)[known]
    return Squares(t_s, age_s[known], (errors_m * solved).sum(axis=1))


def beyond(square: FloatArray, level: float) -> float:
    """Return the share of squares beyond the ellipsoid of a level, NaN for none."""
    return float(np.mean(square > chi2.ppf(level, _NUMBERS))) if len(square) else np.nan


def _share_words(shares: Sequence[float]) -> str:
    """Return the mean of the runs' shares with its interval (%); a run is one draw."""
    known = [share for share in shares if np.isfinite(share)]
    if len(known) < 2:
        return "too few runs"
    low, high = (100.0 * min(max(bound, 0.0), 1.0) for bound in mean_bounds(known))
    return f"{100.0 * np.mean(known):.1f} % ({low:.1f} to {high:.1f})"


def _row(quantity: str, groups: Sequence[FloatArray]) -> Row:
    nees = [float(square.mean()) for square in groups if len(square)]
    words = "; ".join(
        f"{_share_words([beyond(square, level) for square in groups])} beyond {100 * level:g} %"
        for level in LEVELS
    )
    return Row(
        quantity, "5 %, 0.3 %, 3", f"{words}; NEES {np.mean(nees):.2f}", NO_NUMBER, f"{len(nees)} runs"
    )


def _rows(runs: list[Run]) -> list[Row]:
    rows = []
    for case, found in _by_case(runs).items():
        for phase, (from_s, to_s) in PHASES.items():
            part = [one.square[(one.t_s >= from_s) & (one.t_s < to_s)] for one in found]
            rows.append(_row(f"{case}, {phase}", part))
        for low_s, high_s in pairwise(AGES_S):
            part = [one.square[(one.age_s >= low_s) & (one.age_s < high_s)] for one in found]
            until = f"{low_s:g} to {high_s:g} s old" if np.isfinite(high_s) else f"older than {low_s:g} s"
            if any(len(square) for square in part):
                rows.append(_row(f"{case}, information {until}", part))
    return rows


def _by_case(runs: list[Run]) -> dict[str, list[Squares]]:
    n = len(SEEDS)
    return {case: [squares_of(run) for run in runs[n * i : n * (i + 1)]] for i, case in enumerate(CASES)}


def _judge(runs: list[Run]) -> Verdict:
    """Judge both ellipsoids: a filter may be too cautious in most errors and too sure in the tails."""
    words, covered, cautious = [], [], []
    for case, found in _by_case(runs).items():
        for phase, (from_s, to_s) in PHASES.items():
            part = [one.square[(one.t_s >= from_s) & (one.t_s < to_s)] for one in found]
            by_level = [[beyond(square, level) for square in part] for level in LEVELS]
            for level, shares in zip(LEVELS, by_level, strict=True):
                low, high = mean_bounds(shares)
                covered.append(low <= 1.0 - level <= high)
                cautious.append(low <= 1.0 - level)
            words.append(f"{case}, {phase}: {_share_words(by_level[0])} and {_share_words(by_level[1])}")
    evidence = (
        "shares of errors beyond the stated 95 and 99.7 % ellipsoids, where 5 and 0.3 % would be right; "
        f"slots of {_SLOT_S:g} s, {100 * _LOSS:.0f} % lost, n = {len(SEEDS)} flights each, interval over "
        f"flights: {'; '.join(words)}. Too many beyond 99.7 % are errors larger than stated, too few beyond "
        "95 % smaller ones. By age: Table A.36"
    )
    return Verdict(HOLDS if all(covered) else HOLDS_IN_PART if all(cautious) else DOES_NOT_HOLD, evidence)


_EVERY_RUN = tuple(spec for specs in RUNS.values() for spec in specs)

TABLES = (
    Table(
        "A.36",
        "Errors beyond the ellipsoids that the filter states, in flight, by phase and age of information",
        _EVERY_RUN,
        _rows,
        "consistent",
    ),
)

CLAIMS = (
    Claim(
        "A.34",
        "In flight the errors are as large as the filter says, with exact navigation and with drift (ours).",
        _EVERY_RUN,
        _judge,
    ),
)
