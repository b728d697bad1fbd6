"""
Formations over acoustic links: string gain, switching and repair, by length of slot and share of losses.

The law is `displacement` on ODIN-like hulls in a current, with reports of 32 bytes. The thesis and the study
with perfect information have no such numbers.
"""

from __future__ import annotations

from auv_thesis.formation.acoustic_runs import Cell, repair_runs, string_runs, switch_runs
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

TOUCH_M = 0.62
"""Diameter of a hull."""


def _cells(specs: dict[Cell, RunSpec], runs: list[Run]) -> dict[Cell, Run]:
    return dict(zip(specs, runs, strict=True))


def _name(cell: Cell) -> str:
    return f"{cell.case}, slots {cell.slot_s:g} s, {100.0 * cell.loss_prob:.0f} % lost"


def _number(value: object, digits: int = 2) -> str:
    return f"{value:.{digits}f}" if isinstance(value, int | float) else "none"


def _in_place(run: Run) -> str:
    after_s = run.metrics["formation_in_place_after_s"]
    return "never in place" if after_s is None else f"in place after {after_s:.0f} s"


def _string_rows(runs: list[Run]) -> list[Row]:
    return [
        Row(
            _name(cell),
            "not in the thesis",
            f"gain {_number(run.metrics['string_gain_max'])}, formation error rms "
            f"{_number(run.metrics['formation_error_rms_m'])} m, {_in_place(run)}",
            NO_NUMBER,
            f"least distance {_number(run.metrics['pair_distance_min_m'])} m",
        )
        for cell, run in _cells(string_runs(), runs).items()
    ]


def _change_rows(specs: dict[Cell, RunSpec], runs: list[Run]) -> list[Row]:
    return [
        Row(
            _name(cell),
            "not in the thesis",
            f"{_in_place(run)}, error at the end {_number(run.metrics['formation_error_final_m'])} m",
            NO_NUMBER,
            f"least distance {_number(run.metrics['pair_distance_min_m'])} m",
        )
        for cell, run in _cells(specs, runs).items()
    ]


def _switch_rows(runs: list[Run]) -> list[Row]:
    return _change_rows(switch_runs(), runs)


def _repair_rows(runs: list[Run]) -> list[Row]:
    return _change_rows(repair_runs(), runs)


def _judge_apart(runs: list[Run]) -> Verdict:
    least_m = [float(run.metrics["pair_distance_min_m"]) for run in runs]
    touching = sum(each < TOUCH_M for each in least_m)
    verdict = HOLDS if not touching else HOLDS_IN_PART if touching < len(runs) else DOES_NOT_HOLD
    return Verdict(
        verdict,
        f"least distance {min(least_m):.2f} m in {len(runs)} runs, one per cell; hulls touched in {touching}",
    )


_ALL = (*string_runs().values(), *switch_runs().values(), *repair_runs().values())

TABLES = (
    Table("1.G", "A column of 8 over acoustic links", tuple(string_runs().values()), _string_rows),
    Table("1.H", "Switching over acoustic links", tuple(switch_runs().values()), _switch_rows),
    Table("1.I", "Repair over acoustic links", tuple(repair_runs().values()), _repair_rows),
)

CLAIMS = (
    Claim(
        "1.G",
        "Over acoustic links, vehicles in formation stay apart while they switch their shape and repair it.",
        _ALL,
        _judge_apart,
    ),
)
