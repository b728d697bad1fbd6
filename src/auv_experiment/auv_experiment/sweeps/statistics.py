"""Statistics of a metric over runs: mean and median with confidence intervals, and spread."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from auv_experiment.confidence import CONFIDENCE
from auv_experiment.confidence.clusters import NO_INTERVAL, mean_interval, percentile_interval, share_interval
from auv_experiment.confidence.differences import difference_interval

Factors = Mapping[str, Sequence[int]]
"""What runs can have in common, run by run: the numbers of their draws, their seeds."""


@dataclass(frozen=True)
class Summary:
    """
    Statistics of a metric over runs; values that do not exist are None.

    Attributes
    ----------
    n : int
        Number of runs that have the metric.
    mean : float or None
        Their mean; for truth values the share of true ones.
    low, high : float or None
        Bounds of the 95 % confidence interval of the mean.
    method : str
        The method of this interval.
    clusters : str
        What counts as independent in all intervals: '20 seeds', '10 draws x 20 seeds'.
    smallest, median, largest : float or None
        Of the runs.
    median_low, median_high : float or None
        Bounds of the 95 % confidence interval of the median.

    """

    n: int
    mean: float | None = None
    low: float | None = None
    high: float | None = None
    method: str = ""
    clusters: str = ""
    smallest: float | None = None
    median: float | None = None
    median_low: float | None = None
    median_high: float | None = None
    largest: float | None = None


@dataclass(frozen=True)
class Difference:
    """
    A metric's mean difference between two cases, over pairs of runs that have draw and seed in common.

    Attributes
    ----------
    pairs : int
        Number of pairs in which both runs have the metric.
    difference, low, high : float or None
        Mean difference, and bounds of its 95 % confidence interval.
    method, clusters : str
        As of `Summary`.

    """

    pairs: int
    difference: float | None = None
    low: float | None = None
    high: float | None = None
    method: str = ""
    clusters: str = ""


def summarise(
    values: Sequence[bool | float | None], factors: Factors | None = None, *, is_share: bool = False
) -> Summary:
    """
    Return the statistics of a metric; runs without it (None) do not count.

    Parameters
    ----------
    values : sequence
        Numbers or truth values.
    factors : mapping of str to sequence, optional
        What the runs have in common; without it, they are independent.
    is_share : bool
        Whether the metric always lies between 0 and 1, so that its interval must, too.

    """
    given = [row for row, value in enumerate(values) if value is not None]
    if not given:
        return Summary(0)
    numbers = np.array([values[row] for row in given], dtype=np.float64)
    codes = _codes_of(given, factors or {})
    is_truth = all(isinstance(values[row], bool) for row in given)
    interval = (share_interval if is_truth else mean_interval)(numbers, *codes.values())
    around_median = NO_INTERVAL if is_truth else percentile_interval(numbers, 0.5, *codes.values())
    low, high = interval.low, interval.high
    if is_share and low is not None and high is not None:
        low, high = max(low, 0.0), min(high, 1.0)
    return Summary(
        len(given),
        float(numbers.mean()),
        low,
        high,
        interval.method,
        _words(len(given), codes),
        float(numbers.min()),
        float(np.median(numbers)),
        around_median.low,
        around_median.high,
        float(numbers.max()),
    )


def compare(pairs: Sequence[tuple[bool | float | None, bool | float | None]], factors: Factors) -> Difference:
    """
    Return the mean of first minus second value over pairs; those that lack a value do not count.

    Parameters
    ----------
    pairs : sequence of (value, value)
        Numbers or truth values.
    factors : mapping of str to sequence
        What the pairs have in common.

    """
    given = [row for row, pair in enumerate(pairs) if None not in pair]
    if not given:
        return Difference(0)
    firsts, seconds = (np.array([pairs[row][side] for row in given], dtype=np.float64) for side in (0, 1))
    is_truth = all(isinstance(value, bool) for row in given for value in pairs[row])
    codes = _codes_of(given, factors)
    found = difference_interval(firsts, seconds, *codes.values(), is_truth=is_truth)
    mean = float((firsts - seconds).mean())
    return Difference(len(given), mean, found.low, found.high, found.method, _words(len(given), codes))


def distribution_band(n: int) -> float:
    """
    Return the half width of the 95 % band around the distribution of n independent samples
    (Dvoretzky-Kiefer-Wolfowitz).
    """
    return math.sqrt(math.log(2.0 / (1.0 - CONFIDENCE)) / (2.0 * n))


def _codes_of(rows: Sequence[int], factors: Factors) -> dict[str, Any]:
    """Return the factors that differ among rows."""
    codes = {name: np.array([factor[row] for row in rows]) for name, factor in factors.items()}
    return {name: code for name, code in codes.items() if len(np.unique(code)) > 1} or dict(
        [*codes.items()][:1]
    )


def _words(n: int, codes: Mapping[str, Any]) -> str:
    if not codes:
        return f"{n} runs"
    counts = {name: len(np.unique(code)) for name, code in codes.items()}
    return " x ".join(
        f"{count} {name if count != 1 else name.removesuffix('s')}" for name, count in counts.items()
    )
