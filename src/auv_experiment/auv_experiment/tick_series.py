"""Numbers of a bag in order: by tick, with values for missed ticks, or row by row."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
OrderArray = NDArray[np.uint64]
"""(n, 2): log time (ns) and place in the bag of each message."""


class TickSeries:
    """
    Values of one quantity of one vehicle by tick.

    Parameters
    ----------
    width : int
        Smallest number of values in a tick. If more are added, shorter rows end in NaN.

    """

    def __init__(self, width: int = 0) -> None:
        self.width = width
        self._blocks: list[tuple[OrderArray, IntArray, FloatArray]] = []

    def add(self, order: OrderArray, ticks: IntArray, values: FloatArray) -> None:
        """Add the (n, width) values of n messages."""
        self._blocks.append((order, np.array(ticks, np.int64), values))
        self.width = max(self.width, values.shape[1])

    @property
    def last_tick(self) -> int:
        """Last tick with a value, -1 if there is none."""
        ticks, _ = self.latest
        return int(ticks[-1]) if len(ticks) else -1

    @cached_property
    def latest(self) -> tuple[IntArray, FloatArray]:
        """Ticks in ascending order, and the values that were recorded last for each."""
        order, ticks = np.empty((0, 2), np.uint64), np.empty(0, np.int64)
        values = np.empty((0, self.width))
        if self._blocks:
            order = np.concatenate([block for block, _, _ in self._blocks])
            ticks = np.concatenate([block for _, block, _ in self._blocks])
            values = np.concatenate([_widened(block, self.width) for _, _, block in self._blocks])
            self._blocks.clear()
        rows = _as_recorded(order, ticks)
        last = rows[np.append(np.diff(ticks[rows]) > 0, True)] if len(rows) else rows
        return ticks[last], values[last]

    def table(self, n_rows: int, *, held_to: int | None) -> FloatArray:
        """
        Return (n_rows, width): missing rows repeat the one before, NaN before the first.

        Parameters
        ----------
        n_rows : int
            Number of ticks.
        held_to : int or None
            Last tick that repeats the one before; None for the last one with a value.

        """
        ticks, values = self.latest
        kept = slice(*np.searchsorted(ticks, [0, n_rows]))
        ticks, values = ticks[kept], values[kept]
        table = np.full((n_rows, self.width), np.nan)
        if len(ticks):
            stop = min(n_rows, 1 + (int(ticks[-1]) if held_to is None else held_to))
            held = np.arange(ticks[0], stop)
            table[held] = values[np.searchsorted(ticks, held, side="right") - 1]
            table[ticks] = values
        return table

    def ages(self, n_rows: int) -> IntArray:
        """Return (n_rows,): ticks since the last value, or since tick 0 before the first."""
        latest = np.zeros(n_rows, dtype=np.int64)
        ticks, _ = self.latest
        known = ticks[(ticks >= 0) & (ticks < n_rows)]
        latest[known] = known
        ages: IntArray = np.arange(n_rows) - np.maximum.accumulate(latest)
        return ages


class RecordedRows:
    """Rows of numbers: packets, contacts or lines of a log, any number in a message."""

    def __init__(self, width: int) -> None:
        self._order = [np.empty((0, 2), np.uint64)]
        self._rows = [np.empty((0, width))]

    def add(self, order: OrderArray, rows: FloatArray) -> None:
        """Add a row of each of n messages; further rows of the same messages follow in further calls."""
        self._order.append(order)
        self._rows.append(rows)

    def by(self, *columns: int) -> FloatArray:
        """Return the rows by these columns, the first one first, and rows that agree in them as recorded."""
        rows = np.concatenate(self._rows)
        ordered: FloatArray = rows[
            _as_recorded(np.concatenate(self._order), *(rows[:, each] for each in columns))
        ]
        return ordered


def _as_recorded(order: OrderArray, *first: NDArray) -> NDArray[np.intp]:
    """Return the indices that sort by the arrays `first`, then by time and place of the messages."""
    time_ns, place = order[:, 0], order[:, 1]
    return np.lexsort((place, time_ns, *reversed(first)))


def _widened(values: FloatArray, width: int) -> FloatArray:
    missing = width - values.shape[1]
    return np.pad(values, ((0, 0), (0, missing)), constant_values=np.nan) if missing else values
