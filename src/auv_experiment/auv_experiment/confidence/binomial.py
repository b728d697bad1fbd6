"""
Confidence intervals of a share, from k of n independent runs.

`exact_bounds` never covers less than it says, and so covers more for small n. `wilson_interval` covers what
it says on average over shares. For "none of n" the bound of interest is one-sided: `exact_upper_bound`.

Sources: Clopper and Pearson, Biometrika 26 (1934); Wilson, JASA 22 (1927); Brown, Cai and DasGupta,
Statistical Science 16 (2001).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import betaincinv, ndtri

from auv_experiment.confidence import CONFIDENCE

FloatArray = NDArray[np.float64]


def exact_bounds(k: int, n: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """
    Return the two-sided exact interval of a share of which k of n independent runs were (Clopper, Pearson).

    Parameters
    ----------
    k : int
        Number of runs in which it happened, from 0 to n.
    n : int
        Number of runs, at least 1.
    confidence : float
        The interval covers the true share at least this often.

    Returns
    -------
    low, high : float
        Between 0 and 1; `low` is 0 for k = 0, `high` is 1 for k = n.

    """
    _check(k, n)
    tail = 0.5 * (1.0 - confidence)
    low = 0.0 if k == 0 else float(betaincinv(k, n - k + 1, tail))
    high = 1.0 if k == n else float(betaincinv(k + 1, n - k, 1.0 - tail))
    return low, high


def exact_upper_bound(k: int, n: int, confidence: float = CONFIDENCE) -> float:
    """
    Return the share that is exceeded with at most 1 - `confidence`: the one-sided exact bound.

    For k = 0 it is 1 - (1 - confidence)^(1/n), about 3 / n at 95 %: none of 600 is a share under 0.5 %, none
    of 100 one under 3 %.
    """
    _check(k, n)
    return 1.0 if k == n else float(betaincinv(k + 1, n - k, confidence))


def wilson_interval(successes: ArrayLike, trials: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """
    Return the 95 % score interval of a share (Wilson).

    Parameters
    ----------
    successes, trials : array_like
        Of one shape; trials above 0. They need not be whole (an effective number of trials).

    """
    k, n = np.asarray(successes, dtype=np.float64), np.asarray(trials, dtype=np.float64)
    z = float(ndtri(0.5 + 0.5 * CONFIDENCE))
    share = k / n
    middle = (share + z * z / (2.0 * n)) / (1.0 + z * z / n)
    half = z * np.sqrt(share * (1.0 - share) / n + (z / (2.0 * n)) ** 2) / (1.0 + z * z / n)
    return np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)


def share_words(k: int, n: int) -> str:
    """
    Return a count with the 95 % exact bounds of its share, for a sentence or a cell of a table.

    Examples
    --------
    >>> share_words(0, 600)
    'none of 600 (under 0.5 %)'
    >>> share_words(12, 13)
    '12 of 13 (63 to 99.81 %)'
    >>> share_words(20, 20)
    'all 20 (over 86 %)'

    """
    if k == 0:
        return f"none of {n} (under {_percent_above(exact_upper_bound(0, n))} %)"
    if k == n:
        return f"all {n} (over {_percent_below(1.0 - exact_upper_bound(0, n))} %)"
    low, high = exact_bounds(k, n)
    return f"{k} of {n} ({_percent_below(low)} to {_percent_above(high)} %)"


def _percent_above(share: float) -> str:
    """Return a share in percent, rounded up to two digits of it or of what is missing to 100 %."""
    return _rounded(100.0 * share, math.ceil)


def _percent_below(share: float) -> str:
    """Return a share in percent, rounded down to two digits of it or of what is missing to 100 %."""
    return _rounded(100.0 * share, math.floor)


def _rounded(percent: float, towards: Callable[[float], int]) -> str:
    distance = min(percent, 100.0 - percent)
    digits = max(0, 1 - math.floor(math.log10(distance))) if distance > 0.0 else 0
    text = f"{towards(round(percent * 10.0**digits, 6)) / 10.0**digits:.{digits}f}"
    return text.rstrip("0").rstrip(".") if digits else text


def _check(k: int, n: int) -> None:
    if not 0 <= k <= n or n < 1:
        raise ValueError(f"{k} of {n} is no count of runs; allowed: 0 to n of at least 1")
