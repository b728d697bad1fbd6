"""
Switching between shapes and repair after a loss, thesis Sections 1.10.3 and 1.10.4.

The expected numbers are those of a separate study with its own program.
"""

from __future__ import annotations

import math

from auv_thesis.formation.cases import SPACING_M
from auv_thesis.formation.manoeuvre_cases import (
    NOTICED_AFTER_S,
    PATHS,
    SWITCHES,
    repair_numbers,
    straight_separation_m,
    switch_numbers,
)
from auv_thesis.items import (
    AGREES,
    AGREES_IN_PART,
    DIFFERS,
    DOES_NOT_HOLD,
    HOLDS,
    HOLDS_IN_PART,
    Claim,
    Row,
    Run,
    Table,
    Verdict,
)

BOUND_M = SPACING_M / math.sqrt(2.0)
_EXPECTED_SEPARATION_M = (8.16, 7.07, 7.07, 7.07, 9.24, 9.24)
_EXPECTED_S = (54.0, 57.0)
_EXPECTED_REPAIR_M = {"line": 10.0, "wedge": 7.07, "column": 10.0}
_EXPECTED_REPAIR_S = (38.0, 40.0)


def _within(value: float, low: float, high: float, tolerance: float) -> bool:
    return low - tolerance <= value <= high + tolerance


def _switch_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for (before, after), expected_m in zip(SWITCHES, _EXPECTED_SEPARATION_M, strict=True):
        for path in PATHS:
            ours = switch_numbers(before, after, path)
            good = [
                _within(ours.switch_s, *_EXPECTED_S, 1.0),
                abs(ours.separation_m - expected_m) <= 0.02,
                _within(ours.force_n, 62.0, 1145.0, 1.0),
            ]
            rows.append(
                Row(
                    f"{before} to {after}, {path}: time (s), least distance (m), largest force (N)",
                    f"54 to 57, {expected_m:.2f}, 62 to 1145",
                    f"{ours.switch_s:.1f}, {ours.separation_m:.2f}, {ours.force_n:.0f}",
                    AGREES if all(good) else AGREES_IN_PART if any(good) else DIFFERS,
                    f"straight ways: {straight_separation_m(before, after):.2f} m",
                )
            )
    return rows


def _repair_rows(runs: list[Run]) -> list[Row]:
    rows = []
    for name in ("leader", "predecessor", "neighbour"):
        ours = repair_numbers("column", name, repairs=False)
        expected_m = 0.0 if name == "leader" else 98.9
        rows.append(
            Row(
                f"column, {name}, no repair: distance from the slot at 260 s (m)",
                f"{expected_m:.1f}",
                f"{ours.away_m:.1f}",
                AGREES if abs(ours.away_m - expected_m) <= 0.1 else DIFFERS,
                f"the lost vehicle glides {ours.glide_m:.2f} m (expected 1.10)",
            )
        )
    for shape, expected_m in _EXPECTED_REPAIR_M.items():
        ours = repair_numbers(shape, "predecessor", repairs=True)
        repair_s = ours.repair_s + NOTICED_AFTER_S
        good = [
            _within(repair_s, *_EXPECTED_REPAIR_S, 1.0),
            ours.separation_m >= expected_m - 0.1,
        ]
        rows.append(
            Row(
                f"{shape}, repaired: time from the loss (s), least distance of live vehicles (m)",
                f"38 to 40, {expected_m:.2f}",
                f"{repair_s:.1f}, {ours.separation_m:.2f}",
                AGREES if all(good) else AGREES_IN_PART if any(good) else DIFFERS,
                f"least distance to the lost one {ours.wreck_m:.2f} m",
            )
        )
    ours = repair_numbers("column", "predecessor", repairs=True, avoids=True)
    repair_s = ours.repair_s + NOTICED_AFTER_S
    good = [abs(repair_s - 55.0) <= 1.0, abs(ours.wreck_m - 2.0) <= 0.1, ours.separation_m >= 6.3]
    rows.append(
        Row(
            "column, repaired, swirl around the lost one: time (s), distances to it and of live ones (m)",
            "55, 2.0, 6.3",
            f"{repair_s:.1f}, {ours.wreck_m:.2f}, {ours.separation_m:.2f}",
            AGREES if all(good) else AGREES_IN_PART if any(good) else DIFFERS,
        )
    )
    return rows


def _judge_switching(runs: list[Run]) -> Verdict:
    numbers = [switch_numbers(*shapes, path) for shapes in SWITCHES for path in PATHS]
    least_m, slowest_s = min(n.separation_m for n in numbers), max(n.switch_s for n in numbers)
    verdict = HOLDS if least_m >= BOUND_M - 0.02 and math.isfinite(slowest_s) else DOES_NOT_HOLD
    return Verdict(
        verdict,
        f"{len(numbers)} switches of six vehicles: all in place after at most {slowest_s:.1f} s, least "
        f"distance {least_m:.2f} m, bound d / sqrt(2) = {BOUND_M:.2f} m",
    )


def _judge_repair(runs: list[Run]) -> Verdict:
    numbers = {shape: repair_numbers(shape, "predecessor", repairs=True) for shape in _EXPECTED_REPAIR_M}
    around = repair_numbers("column", "predecessor", repairs=True, avoids=True)
    is_repaired = all(math.isfinite(n.repair_s) for n in (*numbers.values(), around))
    runs_over = [shape for shape, n in numbers.items() if n.wreck_m < 0.62]
    verdict = DOES_NOT_HOLD if not is_repaired else HOLDS_IN_PART if runs_over else HOLDS
    return Verdict(
        verdict,
        "repaired in all shapes; without avoidance live vehicles run over the lost one in "
        f"{', '.join(runs_over) or 'none'}; with a swirl around it they keep {around.wreck_m:.2f} m",
    )


TABLES = (
    Table("1.E", "Switching of six vehicles in 60 s", (), _switch_rows, "expected"),
    Table("1.F", "Repair of six vehicles after the loss of the third", (), _repair_rows, "expected"),
)

CLAIMS = (
    Claim("1.10.3", "A group changes from one shape to another without collisions.", (), _judge_switching),
    Claim(
        "1.10.4",
        "A formation is repaired by new positions, and the lost vehicle is an obstacle for the others.",
        (),
        _judge_repair,
    ),
)
