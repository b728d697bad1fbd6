"""Words for what several runs show: a mean, or a difference between paired runs, with its 95 % interval."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from auv_experiment.confidence.clusters import Interval, mean_interval, percentile_interval
from auv_experiment.confidence.differences import difference_interval


def mean_bounds(values: Sequence[float]) -> tuple[float, float]:
    """Return the 95 % interval of the mean of independent runs."""
    return _bounds(mean_interval(values), len(values))


def mean_words(values: Sequence[float], unit: str, digits: int = 2) -> str:
    """
    Return the mean with its 95 % interval; equal values have no interval.

    Parameters
    ----------
    values : sequence
        One number per run.
    unit : str
        Their unit, or nothing.
    digits : int
        Digits behind the point.

    """
    mean = f"{np.mean(values):.{digits}f} {unit}".rstrip()
    low, high = mean_bounds(values)
    if low == high:
        return mean
    return f"{mean} ({low:.{digits}f} to {high:.{digits}f})"


def median_bounds(values: Sequence[float]) -> tuple[float, float]:
    """Return the 95 % interval of the median, which single outliers do not move."""
    return _bounds(percentile_interval(values, 0.5), len(values))


def median_words(values: Sequence[float], unit: str, digits: int = 2) -> str:
    """Return the median with its 95 % interval."""
    low, high = median_bounds(values)
    return f"{float(np.median(values)):.{digits}f} {unit} ({low:.{digits}f} to {high:.{digits}f})"


def difference_bounds(ours: Sequence[float], others: Sequence[float]) -> tuple[float, float]:
    """Return the 95 % interval of the mean of `ours - others`, paired run by run."""
    return _bounds(difference_interval(ours, others), len(ours))


def difference_words(ours: Sequence[float], others: Sequence[float], unit: str, digits: int = 2) -> str:
    """Return the 95 % interval of the mean of `ours - others`, paired run by run."""
    low, high = difference_bounds(ours, others)
    return f"{low:+.{digits}f} to {high:+.{digits}f} {unit}"


def _bounds(found: Interval, n: int) -> tuple[float, float]:
    if found.low is None or found.high is None:
        raise ValueError(f"{n} run(s) have no interval; allowed: at least 2")
    return found.low, found.high
