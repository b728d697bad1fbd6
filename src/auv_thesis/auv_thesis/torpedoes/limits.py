"""What runs must keep: a number of each run, its limit, and the share of runs that may be beyond it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from auv_experiment.confidence.binomial import exact_bounds, share_words
from auv_thesis.items import Run

_ROUNDING = 1e-9


class _Quantity(NamedTuple):
    """Words, unit, and whether more is worse."""

    words: str
    unit: str
    is_worse_above: bool


_QUANTITIES = {
    "pair_distance_min_m": _Quantity("distance", "m", False),
    "pair_distance_working_min_m": _Quantity("distance of working vehicles", "m", False),
    "wreck_distance_min_m": _Quantity("distance to the wreck", "m", False),
    "coordination_error_after_700s_p95_m": _Quantity("coordination error (95 %)", "m", True),
    "cross_track_rms_m": _Quantity("cross-track error (rms)", "m", True),
    "cross_track_max_m": _Quantity("cross-track error", "m", True),
    "packets_per_minute_after_700s": _Quantity("packets per minute", "", True),
    "fleet_formed_at_s": _Quantity("time to form", "s", True),
}


@dataclass(frozen=True)
class Limit:
    """
    A limit on a metric of every run.

    Attributes
    ----------
    key : str
        The metric, one of those that have words here.
    value : float
        The limit, in the unit of the metric.
    most : float
        Largest share of the runs that may be beyond the limit.
    least : float
        Smallest share of the runs that must be beyond it: a control that is to fail.

    """

    key: str
    value: float
    most: float = 0.0
    least: float = 0.0

    def __post_init__(self) -> None:
        if self.key not in _QUANTITIES:
            raise ValueError(f"key: {self.key!r} is not allowed; allowed: {', '.join(_QUANTITIES)}")

    @property
    def quantity(self) -> _Quantity:
        """What the metric is."""
        return _QUANTITIES[self.key]

    def __str__(self) -> str:
        """Return the limit as text."""
        what, above = self.quantity.words, self.quantity.is_worse_above
        if self.least > 0.0:
            return f"{what} {'over' if above else 'under'} {self._shown(self.value)} in at least " + _percent(
                self.least
            )
        share = f", but for {_percent(self.most)}" if self.most > 0.0 else ""
        return f"{what} {'at most' if above else 'at least'} {self._shown(self.value)}{share}"

    def _shown(self, value: float) -> str:
        if math.isinf(value):
            return "infinite"
        return f"{value:.4g} {self.quantity.unit}".rstrip()

    def values(self, runs: Sequence[Run]) -> list[float]:
        """
        Return the number of every run; a missing time or error counts as infinite, a missing distance as far.
        """
        found = [run.metrics[self.key] for run in runs]
        return [math.inf if value is None else float(value) for value in found]

    def worst(self, runs: Sequence[Run]) -> str:
        """Return the worst number of the runs as text."""
        values = self.values(runs)
        worst = max(values) if self.quantity.is_worse_above else min(values)
        return f"{self.quantity.words} {self._shown(worst)}"

    def count_beyond(self, runs: Sequence[Run]) -> int:
        """Return how many runs are beyond the limit."""
        values = self.values(runs)
        if self.quantity.is_worse_above:
            return sum(value > self.value for value in values)
        return sum(value < self.value for value in values)

    def beyond(self, runs: Sequence[Run]) -> str:
        """Return how many runs are beyond the limit, with the exact bounds of their share."""
        side = "over" if self.quantity.is_worse_above else "under"
        share = share_words(self.count_beyond(runs), len(runs))
        return f"{self.quantity.words} {side} {self._shown(self.value)} in {share}"

    def is_kept(self, runs: Sequence[Run], n_all: int) -> bool:
        """
        Return whether the runs keep the limit, of which there are `n_all`.

        While some are not flown, a share is beyond its limit only if its exact bounds exclude the limit.
        """
        n, count = len(runs), self.count_beyond(runs)
        low, high = exact_bounds(count, n) if n < n_all else (count / n, count / n)
        if self.most == self.least == 0.0:
            return count == 0
        return high >= self.least - _ROUNDING and (self.least > 0.0 or low <= self.most + _ROUNDING)


def _percent(share: float) -> str:
    return f"{100.0 * share:g} % of the runs"
