"""Lines of the benchmark's table, and their measurement: medians of alternating blocks."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """
    One line of the table: a value, its comparison value, and their ratio.

    `bar` is the target, `kept` tells whether it was reached; None without a target.
    """

    figure: str
    value: str
    limit: str = ""
    ratio: str = ""
    bar: str = ""
    kept: bool | None = None


def taking_turns(measures: Sequence[Callable[[], float]], blocks: int) -> list[list[float]]:
    """Return the values of each measure in alternating blocks, so that all run under the same conditions."""
    found: list[list[float]] = [[] for _ in measures]
    for _ in range(blocks):
        for values, measure in zip(found, measures, strict=True):
            values.append(measure())
    return found


def spread(values: Sequence[float], form: str = "{:,.0f}") -> str:
    """Return median, least and largest."""
    low, middle, high = (form.format(x) for x in (min(values), statistics.median(values), max(values)))
    return f"{middle} [{low}..{high}]"


def cpu_seconds(work: Callable[[], object], at_least_s: float) -> float:
    """Return the processor time of one call (s); the call is repeated for at least the given time."""
    calls, began_s = 0, time.process_time()
    while (spent_s := time.process_time() - began_s) < at_least_s or not calls:
        work()
        calls += 1
    return spent_s / calls
