"""Statistics of a metric over runs: mean, confidence interval and spread."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student_t

from auv_experiment.confidence import CONFIDENCE
from auv_experiment.confidence.binomial import wilson_interval
from auv_experiment.recording import FloatArray


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
        Bounds of the 95 % confidence interval of the mean: Student's t (at least two runs), or for a share
        the score interval (Wilson 1927).
    smallest, median, largest : float or None
        Of the runs.

    """

    n: int
    mean: float | None = None
    low: float | None = None
    high: float | None = None
    smallest: float | None = None
    median: float | None = None
    largest: float | None = None


def summarise(values: Sequence[bool | float | None], *, is_share: bool = False) -> Summary:
    """
    Return the statistics of a metric; runs without it (None) do not count.

    Parameters
    ----------
    values : sequence
        Numbers or truth values.
    is_share : bool
        Whether the metric always lies between 0 and 1, so that its interval must, too.

    """
    given = [value for value in values if value is not None]
    if not given:
        return Summary(0)
    numbers = np.array(given, dtype=np.float64)
    if all(isinstance(value, bool) for value in given):
        bounds = wilson_interval(np.array(numbers.sum()), np.array(len(numbers)))
        low, high = (float(bound) for bound in bounds)
    else:
        low, high = _student(numbers)
        if is_share:
            low, high = max(low, 0.0), min(high, 1.0)
    return Summary(
        len(given),
        float(numbers.mean()),
        None if math.isnan(low) else low,
        None if math.isnan(high) else high,
        float(numbers.min()),
        float(np.median(numbers)),
        float(numbers.max()),
    )


def distribution_band(n: int) -> float:
    """
    Return the half width of the 95 % band around the distribution of n samples
    (Dvoretzky-Kiefer-Wolfowitz).
    """
    return math.sqrt(math.log(2.0 / (1.0 - CONFIDENCE)) / (2.0 * n))


def _student(numbers: FloatArray) -> tuple[float, float]:
    """Return Student's interval of the mean, NaN for a single number."""
    n = len(numbers)
    if n < 2:
        return math.nan, math.nan
    half = float(student_t.ppf(0.5 + CONFIDENCE / 2.0, n - 1) * numbers.std(ddof=1) / math.sqrt(n))
    mean = float(numbers.mean())
    return mean - half, mean + half
