"""Three claims of the thesis's abstract and conclusions that no chapter of it shows, judged from runs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from auv_thesis.cases import by_case
from auv_thesis.ch4_6.flock_runs import (
    EQUAL_FOUR_LEADERS,
    EQUAL_ONE_LEADER,
    FOUR_LEADERS,
    FUZZY_FOUR_LEADERS,
    FUZZY_OBSTACLES,
    FUZZY_ONE_LEADER,
    OBSTACLES,
    ONE_LEADER,
)
from auv_thesis.intervals import (
    difference_bounds,
    difference_words,
    mean_words,
    median_bounds,
    median_words,
)
from auv_thesis.items import (
    DOES_NOT_HOLD,
    HOLDS,
    HOLDS_IN_PART,
    NO_NUMBER,
    Claim,
    Row,
    Run,
    Table,
    Verdict,
)
from auv_thesis.laws.computing import ADAPTIVE, LAWS, ON_A_HULL, REPEATS, SIZES, times_us
from auv_thesis.laws.separation_laws import deviation_m
from auv_thesis.laws.separation_runs import DRAWN, NOMINAL, SEEDS, damping, spec_of
from auv_thesis.laws.separation_runs import LAWS as SEPARATION_LAWS

_THESIS_SIZE = 4
_SAME_M = 1e-3
"""Path errors that differ by less are the same."""
_FUZZY, _EQUAL = tuple(SEPARATION_LAWS)[1:3]
_FACTORS = (0.5, 1.5)
_DAMPED = {
    (law, factor): tuple(spec_of(SEPARATION_LAWS[law], damping(factor), seed) for seed in SEEDS)
    for law in (_FUZZY, _EQUAL)
    for factor in _FACTORS
}
_KINEMATIC = (
    FOUR_LEADERS,
    ONE_LEADER,
    OBSTACLES,
    FUZZY_FOUR_LEADERS,
    FUZZY_ONE_LEADER,
    FUZZY_OBSTACLES,
    EQUAL_FOUR_LEADERS,
    EQUAL_ONE_LEADER,
)
_NOMINAL = {law: DRAWN[law, NOMINAL] for law in ("mathematical", _FUZZY, _EQUAL)}


def _time_rows(_runs: list[Run]) -> list[Row]:
    rows = []
    for n in SIZES:
        found = times_us(n)
        for law in LAWS:
            ratio = np.median(found[law]) / np.median(found[ADAPTIVE])
            rows.append(
                Row(
                    f"{n} vehicles, {law}",
                    "no number",
                    f"{np.median(found[law]):.1f} us, {ratio:.2f} times the adaptive formation",
                    NO_NUMBER,
                    f"median of {REPEATS}",
                )
            )
    return rows


def _judge_computing(_runs: list[Run]) -> Verdict:
    found = times_us(_THESIS_SIZE)
    ratios = {law: found[law] / found[ADAPTIVE] for law in LAWS}
    low, high = median_bounds(ratios[ON_A_HULL].tolist())
    words = ", ".join(
        f"{law} {median_words(ratios[law].tolist(), 'times')}" for law in LAWS if law != ADAPTIVE
    )
    largest = SIZES[-1]
    grown = {law: float(np.median(times_us(largest)[law] / times_us(largest)[ADAPTIVE])) for law in LAWS}
    evidence = (
        f"one evaluation for one of {_THESIS_SIZE} vehicles in plain Python, median of n = {REPEATS} "
        f"repeats, compared with the adaptive formation law: {words}. A formation law of chapter 3 uses no "
        f"other vehicle, so its time does not grow with their number; with {largest} vehicles the flocking "
        f"laws take {grown[LAWS[2]]:.0f} and {grown[LAWS[3]]:.0f} times as long. The verdict compares laws "
        "that end in forces"
    )
    return Verdict(HOLDS if high < 1.0 else DOES_NOT_HOLD if low > 1.0 else HOLDS_IN_PART, evidence)


def _path_errors_m(runs: Sequence[Run]) -> list[float]:
    return [float(run.metrics["centroid_path_rms_m"]) for run in runs]


def _judge_path(runs: list[Run]) -> Verdict:
    count = len(_KINEMATIC)
    error_m = dict(zip(_KINEMATIC, _path_errors_m(runs[:count]), strict=True))
    drawn = {law: _path_errors_m(part) for law, part in by_case(_NOMINAL, runs[count:]).items()}
    clear_m = [runs[i].metrics["obstacle_clearance_min_m"] for i in (2, 5)]
    evidence = (
        f"centroid to path, rms, as the thesis simulates it: four leaders {error_m[FOUR_LEADERS]:.4f} m "
        f"mathematical, {error_m[FUZZY_FOUR_LEADERS]:.4f} m fuzzy, {error_m[EQUAL_FOUR_LEADERS]:.4f} m "
        f"mathematical at equal stiffness; one leader {error_m[ONE_LEADER]:.4f}, "
        f"{error_m[FUZZY_ONE_LEADER]:.4f} and {error_m[EQUAL_ONE_LEADER]:.4f} m; past obstacles "
        f"{error_m[OBSTACLES]:.3f} m and {error_m[FUZZY_OBSTACLES]:.3f} m, at least {clear_m[0]:.2f} m and "
        f"{clear_m[1]:.2f} m from them. Separation acts between vehicles and cancels in their mean. On hulls "
        f"with a modem, n = {len(drawn[_FUZZY])} draws, fuzzy minus mathematical, paired: "
        f"{difference_words(drawn[_FUZZY], drawn['mathematical'], 'm', 3)}, at equal stiffness "
        f"{difference_words(drawn[_FUZZY], drawn[_EQUAL], 'm', 3)}"
    )
    better = (
        error_m[FUZZY_FOUR_LEADERS] < error_m[FOUR_LEADERS] - _SAME_M,
        error_m[FUZZY_ONE_LEADER] < error_m[ONE_LEADER] - _SAME_M,
        error_m[FUZZY_OBSTACLES] < error_m[OBSTACLES] - _SAME_M and clear_m[1] >= clear_m[0],
        difference_bounds(drawn[_FUZZY], drawn[_EQUAL])[1] < 0.0,
    )
    return Verdict(HOLDS if all(better) else HOLDS_IN_PART if any(better) else DOES_NOT_HOLD, evidence)


def _judge_damping(runs: list[Run]) -> Verdict:
    """Judge by how much other damping changes what the law is for: distances and the path."""
    count = len(_EVERY_NOMINAL)
    nominal, damped = by_case(_NOMINAL, runs[:count]), by_case(_DAMPED, runs[count:])
    words, better = [], []
    for factor in _FACTORS:
        changes = {
            law: [
                abs(deviation_m(now) - deviation_m(before))
                for now, before in zip(damped[law, factor], nominal[law], strict=True)
            ]
            for law in (_FUZZY, _EQUAL)
        }
        paths = {
            law: [
                abs(now - before)
                for now, before in zip(
                    _path_errors_m(damped[law, factor]), _path_errors_m(nominal[law]), strict=True
                )
            ]
            for law in (_FUZZY, _EQUAL)
        }
        for what, found in (("distances", changes), ("path error", paths)):
            better.append(difference_bounds(found[_FUZZY], found[_EQUAL])[1] < 0.0)
            words.append(
                f"{factor:g} times the damping changes {what} by {mean_words(found[_FUZZY], 'm', 4)} with "
                f"fuzzy, {mean_words(found[_EQUAL], 'm', 4)} with mathematical at equal stiffness"
            )
    evidence = (
        "the thesis's flocks are single integrators, which have no damping. On hulls with a velocity "
        f"controller and a modem, n = {len(nominal[_FUZZY])} draws, compared draw by draw: "
        f"{'; '.join(words)}. Neither law knows or learns the damping"
    )
    return Verdict(HOLDS if all(better) else HOLDS_IN_PART if any(better) else DOES_NOT_HOLD, evidence)


_EVERY_NOMINAL = tuple(spec for specs in _NOMINAL.values() for spec in specs)

TABLES = (
    Table("7.B", "Time of one evaluation of a law for one vehicle, by number of vehicles", (), _time_rows),
)

CLAIMS = (
    Claim(
        "Abstract",
        "Flocking control needs less computational time than formation control.",
        (),
        _judge_computing,
    ),
    Claim(
        "Abstract",
        "Fuzzy potentials improve path following and obstacle avoidance.",
        (*_KINEMATIC, *_EVERY_NOMINAL),
        _judge_path,
    ),
    Claim(
        "Abstract",
        "Fuzzy potentials compensate for uncertain hydrodynamic damping.",
        (*_EVERY_NOMINAL, *(spec for specs in _DAMPED.values() for spec in specs)),
        _judge_damping,
    ),
)
