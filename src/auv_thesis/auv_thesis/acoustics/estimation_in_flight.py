"""
Whether the filter's stated errors are as large as the real ones in flight, by the age of the information.

Table A.32 judges the filter on its own model of motion. Here the truth is the flock of the main job, which
turns, gathers and brakes as no filter's model does. A consistent filter has 5 % of its errors beyond its 95 %
ellipsoid and 0.3 % beyond its 99.7 % ellipsoid, at every age.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from auv_experiment.metrics.neighbours import TAILS, JudgedErrors, by_age, judged_errors, share_beyond
from auv_experiment.metrics.windows import age_words
from auv_experiment.recording import FloatArray
from auv_thesis.acoustics.estimation_runs import DRIFT, DURATION_S, FORMED_S, spec_of
from auv_thesis.cases import by_case
from auv_thesis.intervals import mean_bounds
from auv_thesis.items import DOES_NOT_HOLD, HOLDS, HOLDS_IN_PART, NO_NUMBER, Claim, Row, Run, Table, Verdict

SEEDS = tuple(range(341, 349))
_SLOT_S, _LOSS = 0.5, 0.3
CASES = {"exact navigation": (), "navigations that drift": (DRIFT,)}
RUNS = {
    name: tuple(spec_of(_SLOT_S, _LOSS, *changes, seed=seed) for seed in SEEDS)
    for name, changes in CASES.items()
}
LEVELS = {"95": 0.95, "997": 0.997}
"""The ellipsoids of `TAILS`, as shares that a consistent filter has inside."""
PHASES = {"gathering": (0.0, FORMED_S), "formed": (FORMED_S, DURATION_S)}


def _shares(groups: Sequence[FloatArray], tail: str) -> list[float]:
    """Return the share beyond an ellipsoid in each run's NEES, without the runs that have none."""
    shares = [share_beyond(nees, TAILS[tail]) for nees in groups]
    return [share for share in shares if share is not None]


def _share_words(known: Sequence[float]) -> str:
    """Return the mean of the runs' shares with its interval (%); a run is one draw."""
    if len(known) < 2:
        return "too few runs"
    low, high = (100.0 * min(max(bound, 0.0), 1.0) for bound in mean_bounds(known))
    return f"{100.0 * np.mean(known):.1f} % ({low:.1f} to {high:.1f})"


def _row(quantity: str, groups: Sequence[FloatArray]) -> Row:
    nees = [float(group.mean()) for group in groups if len(group)]
    words = "; ".join(
        f"{_share_words(_shares(groups, tail))} beyond {100 * level:g} %" for tail, level in LEVELS.items()
    )
    return Row(
        quantity, "5 %, 0.3 %, 3", f"{words}; NEES {np.mean(nees):.2f}", NO_NUMBER, f"{len(nees)} runs"
    )


def _rows(runs: list[Run]) -> list[Row]:
    rows = []
    for case, found in _by_case(runs).items():
        for phase, span_s in PHASES.items():
            rows.append(_row(f"{case}, {phase}", [errors.between(*span_s).nees for errors in found]))
        for index, groups in enumerate(zip(*[by_age(errors) for errors in found], strict=True)):
            if any(len(group) for group in groups):
                rows.append(_row(f"{case}, age of the information {age_words(index)}", groups))
    return rows


def _by_case(runs: list[Run]) -> dict[str, list[JudgedErrors]]:
    return by_case(CASES, [judged_errors(run.recording) for run in runs])


def _judge(runs: list[Run]) -> Verdict:
    """Judge both ellipsoids: a filter may be too cautious in most errors and too sure in the tails."""
    words, covered, cautious = [], [], []
    for case, found in _by_case(runs).items():
        for phase, span_s in PHASES.items():
            groups = [errors.between(*span_s).nees for errors in found]
            by_level = [_shares(groups, tail) for tail in LEVELS]
            for level, shares in zip(LEVELS.values(), by_level, strict=True):
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
