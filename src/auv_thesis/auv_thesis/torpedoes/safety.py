"""
Torpedoes in lanes over acoustic links: distances, coordination, losses, silences, and controls that fail.

The thesis has no such vehicles; the limits are ours. Shares have exact 95 % bounds (Clopper and Pearson).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from auv_thesis.items import (
    AGREES,
    AGREES_IN_PART,
    DIFFERS,
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
from auv_thesis.torpedoes.cells import N_SEEDS, Cell
from auv_thesis.torpedoes.studies import (
    CONTROLS,
    COORDINATION,
    DISTANCES,
    LOSSES,
    SILENCES,
    SLOW,
    TURNING_AWAY,
)

COMMAND = f"./scripts/reproduce --only torpedoes --seeds {N_SEEDS}"


def _row(cell: Cell, runs: Sequence[Run]) -> Row:
    limits = "; ".join(map(str, cell.limits))
    if not runs:
        return Row(cell.name, limits, "not flown", NO_NUMBER, f"`{COMMAND}` flies it")
    worst = "; ".join(dict.fromkeys(limit.worst(runs) for limit in cell.limits))
    is_kept = all(limit.is_kept(runs, len(cell.specs)) for limit in cell.limits)
    verdict = DIFFERS if not is_kept else AGREES if len(runs) == len(cell.specs) else AGREES_IN_PART
    return Row(cell.name, limits, worst, verdict, "; ".join(limit.beyond(runs) for limit in cell.limits))


def rows(cells: Sequence[Cell], runs: list[Run]) -> list[Row]:
    """Return a row for each cell."""
    return [_row(cell, cell.runs_among(runs)) for cell in cells]


def judge(cells: Sequence[Cell], runs: list[Run]) -> Verdict:
    """Return whether all limits of the cells are kept: first what is beyond them, then what is flown."""
    flown = {cell: cell.runs_among(runs) for cell in cells}
    flown = {cell: own for cell, own in flown.items() if own}
    broken = [
        f"{cell}: {limit.beyond(own)}"
        for cell, own in flown.items()
        for limit in cell.limits
        if not limit.is_kept(own, len(cell.specs))
    ]
    n_all = sum(len(cell.specs) for cell in cells)
    n_flown = sum(len(own) for own in flown.values())
    is_whole = n_flown == n_all
    words = f"Not kept: {'; '.join(broken)}." if broken else "All limits are kept."
    count = f"{n_flown} runs of {len(cells)} cells."
    if not is_whole:
        some = f"{len(flown)} of {len(cells)} cells"
        count = f"{n_flown} of {n_all} runs are flown, in {some}; `{COMMAND}` flies all."
    holds = DOES_NOT_HOLD if broken else HOLDS if is_whole else HOLDS_IN_PART
    return Verdict(holds, f"{words} {_worst(flown)} {count}".replace("  ", " "))


def _worst(flown: dict[Cell, list[Run]]) -> str:
    """Return the worst number of every quantity that the cells limit."""
    by_key: dict[str, list[Run]] = {}
    limits = {limit.key: limit for cell in flown for limit in cell.limits}
    for cell, own in flown.items():
        for key in {limit.key for limit in cell.limits}:
            by_key.setdefault(key, []).extend(own)
    return f"Worst: {'; '.join(limits[key].worst(own) for key, own in sorted(by_key.items()))}."


_STUDIES: tuple[tuple[str, str, tuple[Cell, ...]], ...] = (
    (
        "Vehicles with random starts, each in a layer of its own",
        "Torpedoes that come to their lanes in layers of their own keep 5 m apart, and form in time.",
        DISTANCES,
    ),
    (
        "Coordination over slots, losses and broadcasts",
        "Neither slow slots nor losses part the path parameters of a fleet that has formed.",
        COORDINATION,
    ),
    ("A vehicle that cannot keep up", "The fleet waits for a vehicle that cannot keep up.", SLOW),
    (
        "A vehicle that is lost and rises",
        "A vehicle that is lost meets no other: in formation never, on the way to the lanes seldom.",
        LOSSES,
    ),
    (
        "Silence of the whole channel",
        "A fleet in formation stays together and apart while nothing is heard for up to five minutes.",
        SILENCES,
    ),
    (
        "Turning away without layers",
        "Without layers, turning away keeps most runs above 5 m; it gives no guarantee.",
        TURNING_AWAY,
    ),
    (
        "Controls that are to fail",
        "Without layers, or without differences of depth in a column, vehicles come near each other.",
        CONTROLS,
    ),
)


def _runs(cells: Sequence[Cell]) -> tuple[RunSpec, ...]:
    return tuple(spec for cell in cells for spec in cell.specs)


TABLES = tuple(
    Table(f"T.{number}", title, _runs(cells), partial(rows, cells), "limit")
    for number, (title, _, cells) in enumerate(_STUDIES, start=1)
)
CLAIMS = tuple(
    Claim(f"T.{number}", f"{claim.removesuffix('.')} (ours).", _runs(cells), partial(judge, cells))
    for number, (_, claim, cells) in enumerate(_STUDIES, start=1)
)
