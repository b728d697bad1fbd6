"""Values of one quantity of one vehicle by tick, and what holds in the ticks that a bag lacks."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass
class TickSeries:
    """Values of one quantity of one vehicle by tick."""

    width: int
    values: dict[int, FloatArray] = field(default_factory=dict)

    def table(self, n_rows: int, *, hold_to_end: bool) -> FloatArray:
        """Return (n_rows, width): missing rows hold the one before, NaN before the first.

        Parameters
        ----------
        n_rows
            Number of ticks.
        hold_to_end
            Hold beyond the last value too; otherwise NaN follows it.
        """
        table = np.full((n_rows, self.width), np.nan)
        ticks = np.array(sorted(tick for tick in self.values if 0 <= tick < n_rows), dtype=np.int64)
        if len(ticks) == 0:
            return table
        stop = n_rows if hold_to_end else ticks[-1] + 1
        rows = np.array([self.values[tick] for tick in ticks])
        source = np.searchsorted(ticks, np.arange(ticks[0], stop), side="right") - 1
        table[ticks[0] : stop] = rows[source]
        return table

    def ages(self, n_rows: int) -> NDArray[np.int64]:
        """Return (n_rows,): ticks since the last value, or since tick 0 before the first."""
        latest = np.zeros(n_rows, dtype=np.int64)
        known = [tick for tick in self.values if 0 <= tick < n_rows]
        latest[known] = known
        ages: NDArray[np.int64] = np.arange(n_rows) - np.maximum.accumulate(latest)
        return ages
