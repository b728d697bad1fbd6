"""
Formations over acoustic links: string gain, switching and repair, by length of slot and share of losses.

The law is `displacement` on ODIN-like hulls in a current, with reports of 32 bytes. The thesis and the study
with perfect information have no such numbers. A row has the worst of its n runs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from auv_experiment.confidence.binomial import share_words
from auv_thesis.acoustics.safety_runs import chosen
from auv_thesis.formation.acoustic_runs import (
    Cell,
    Specs,
    repair_runs,
    string_runs,
    switch_runs,
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

TOUCH_M = 0.62
"""Diameter of a hull."""


def _name(cell: Cell) -> str:
    return f"{cell.case}, slots {cell.slot_s:g} s, {100.0 * cell.loss_prob:.0f} % lost"


def _largest(runs: Sequence[Run], key: str, digits: int = 2) -> str:
    """Return the largest value of a metric, 'none' if a run has none."""
    values = [run.metrics[key] for run in runs]
    return "none" if None in values else f"{max(values):.{digits}f}"


def _in_place(runs: Sequence[Run]) -> str:
    after_s = [run.metrics["formation_in_place_after_s"] for run in runs]
    never = sum(each is None for each in after_s)
    if never:
        return f"never in place in {never} of {len(runs)}"
    return f"in place after {max(after_s):.0f} s"


def _rows(
    specs: Mapping[Cell, Specs], words: Callable[[Sequence[Run]], str]
) -> Callable[[list[Run]], list[Row]]:
    """Return the function that makes a row of each cell, with the worst of its runs."""

    def row(cell: Cell, runs: Sequence[Run]) -> Row:
        if not runs:
            return Row(_name(cell), "not in the thesis", "not flown", NO_NUMBER, "more seeds are needed")
        least_m = min(float(run.metrics["pair_distance_min_m"]) for run in runs)
        remark = f"least distance {least_m:.2f} m; n = {len(runs)}"
        return Row(_name(cell), "not in the thesis", words(runs), NO_NUMBER, remark)

    def rows(runs: list[Run]) -> list[Row]:
        return [row(cell, chosen(runs, each)) for cell, each in specs.items()]

    return rows


def _string_words(runs: Sequence[Run]) -> str:
    return (
        f"gain {_largest(runs, 'string_gain_max')}, formation error rms "
        f"{_largest(runs, 'formation_error_rms_m')} m, {_in_place(runs)}"
    )


def _change_words(runs: Sequence[Run]) -> str:
    return f"{_in_place(runs)}, error at the end {_largest(runs, 'formation_error_final_m')} m"


def _judge_apart(runs: list[Run]) -> Verdict:
    least_m = [float(run.metrics["pair_distance_min_m"]) for run in runs]
    touching = sum(each < TOUCH_M for each in least_m)
    verdict = HOLDS if not touching else HOLDS_IN_PART if touching < len(runs) else DOES_NOT_HOLD
    return Verdict(
        verdict,
        f"least distance {min(least_m):.2f} m; hulls touched in {share_words(touching, len(runs))}",
    )


def _all(specs: Mapping[Cell, Specs]) -> Specs:
    return tuple(spec for each in specs.values() for spec in each)


_STRINGS, _SWITCHES, _REPAIRS = (_all(runs()) for runs in (string_runs, switch_runs, repair_runs))

TABLES = (
    Table("1.G", "A column of 8 over acoustic links", _STRINGS, _rows(string_runs(), _string_words)),
    Table("1.H", "Switching over acoustic links", _SWITCHES, _rows(switch_runs(), _change_words)),
    Table("1.I", "Repair over acoustic links", _REPAIRS, _rows(repair_runs(), _change_words)),
)

CLAIMS = (
    Claim(
        "1.G",
        "Over acoustic links, vehicles in formation stay apart while they switch their shape and repair it.",
        (*_STRINGS, *_SWITCHES, *_REPAIRS),
        _judge_apart,
    ),
)
