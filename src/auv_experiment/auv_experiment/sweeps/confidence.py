"""What many runs of one thing amount to: a mean, how far it may be off, and how far runs lie apart."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student_t

from auv_experiment.figures.plotting import wilson_interval
from auv_experiment.recording import FloatArray

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Summary:
    """
    A metric over runs; what does not exist is None.

    Attributes
    ----------
    n : int
        Runs that have the metric.
    mean : float or None
        Their mean; of truth values the share that is true.
    low, high : float or None
        Bounds of the 95 % confidence interval of the mean: Student's t (two runs at least), of a share the
        score interval (Wilson 1927).
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
    Return what a metric amounts to; runs without it (None) do not count.

    Parameters
    ----------
    values : sequence
        Numbers or truth values.
    is_share : bool
        The metric lies between 0 and 1 whatever happens, so that its interval does, too.

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
    """Return the half width of the 95 % band of a distribution by n samples (Dvoretzky-Kiefer-Wolfowitz)."""
    return math.sqrt(math.log(2.0 / (1.0 - CONFIDENCE)) / (2.0 * n))


def _student(numbers: FloatArray) -> tuple[float, float]:
    """Return Student's interval of the mean, NaN for a single number."""
    n = len(numbers)
    if n < 2:
        return math.nan, math.nan
    half = float(student_t.ppf(0.5 + CONFIDENCE / 2.0, n - 1) * numbers.std(ddof=1) / math.sqrt(n))
    mean = float(numbers.mean())
    return mean - half, mean + half
