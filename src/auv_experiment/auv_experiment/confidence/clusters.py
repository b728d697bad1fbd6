"""
Confidence intervals over runs that are not independent: those of one draw, or of one seed, are a cluster.

Symbols: y_i value of run i, m mean of n values, Z_ab = sum of (y_i - m) / n over the runs of draw a and seed
b, A draws, B seeds. Each run adds its Z to the error of the mean, so the sums of Z over a draw, and over a
seed, are independent terms of that error.

* One factor: V = A / (A - 1) sum_a Z_a^2, with A - 1 degrees of freedom.
* Draws crossed with seeds: V = V_draws + V_seeds - V_rest, but not less than either of the first two. V_rest
  comes from what is left of Z_ab without its row and column, since both sums contain it. Degrees of freedom
  by Satterthwaite, but at least those of the factor with fewer clusters.

The interval of a mean is Student's t after Hall's cubic transformation, which removes the skewness of the
sums of Z. It covers as often as a bootstrap-t, without random numbers, and more often than other bootstraps
(`test_intervals_cover.py`). With fewer than `SKEWNESS_FROM` clusters no estimate of skewness is of use, and
it is Student's.

Sources: Hall, J. R. Statist. Soc. B 54 (1992), p. 221; Cameron, Gelbach and Miller, J. Bus. Econ. Stat. 29
(2011); Korn and Graubard, Survey Methodology 24 (1998); Woodruff, JASA 47 (1952); Hutson, J. Appl. Stat. 26
(1999). Deviation: Korn and Graubard take exact bounds at the effective number of runs, `share_interval` takes
Wilson's.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq
from scipy.special import betainc, ndtri, stdtrit

from auv_experiment.confidence import CONFIDENCE
from auv_experiment.confidence.binomial import wilson_interval

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

SKEWNESS_FROM = 5
_UPPER = 0.5 + 0.5 * CONFIDENCE
STUDENT, HALL, WILSON, EFFECTIVE_WILSON = (
    "Student's t",
    "t corrected for skewness",
    "Wilson",
    "Wilson at the effective number of runs",
)


@dataclass(frozen=True)
class Interval:
    """
    A confidence interval.

    Attributes
    ----------
    low, high : float or None
        Bounds, in the unit of the values; None if so few runs give no bound.
    method : str
        Its name; '' if there is no interval.

    """

    low: float | None
    high: float | None
    method: str


NO_INTERVAL = Interval(None, None, "")


class Spread(NamedTuple):
    """Standard error of a mean, its degrees of freedom, and the skewness of the mean (0 if unknown)."""

    error: float
    dof: float
    skewness: float


def mean_interval(values: ArrayLike, *factors: ArrayLike) -> Interval:
    """
    Return the interval of the mean.

    Parameters
    ----------
    values : (n,) array_like
        Values of the runs.
    factors : (n,) array_like
        Numbers of the runs' draws or seeds: one factor or two. Without one, runs are independent.

    """
    y = np.asarray(values, dtype=np.float64)
    spread = spread_of_mean(y, *factors)
    if spread is None:
        return NO_INTERVAL
    if spread.skewness == 0.0:
        half = float(stdtrit(spread.dof, _UPPER)) * spread.error
        return Interval(float(y.mean()) - half, float(y.mean()) + half, STUDENT)
    low, high = _hall(float(y.mean()), spread)
    return Interval(low, high, HALL)


def share_interval(values: ArrayLike, *factors: ArrayLike) -> Interval:
    """
    Return the interval of the share of true values: Wilson's, at as many runs as the clusters are worth.

    If all values are the same, nothing shows what a cluster is worth, and it counts as one run.

    Parameters
    ----------
    values : (n,) array_like
        Truth values of the runs.
    factors : (n,) array_like
        As of `mean_interval`.

    """
    y = np.asarray(values, dtype=np.float64)
    if not len(y):
        return NO_INTERVAL
    share, worth = float(y.mean()), effective_runs(y, *factors)
    low, high = wilson_interval(share * worth, worth)
    return Interval(float(low), float(high), WILSON if worth == len(y) else EFFECTIVE_WILSON)


def percentile_interval(values: ArrayLike, share: float, *factors: ArrayLike) -> Interval:
    """
    Return the interval of a percentile, for any distribution: from order statistics, interpolated (Hutson).

    Clusters count as in `share_interval`, for the share of values up to the percentile (Woodruff). A bound is
    None if it would lie outside the values: the 95th percentile has an upper bound from 72 runs on.

    Parameters
    ----------
    values : (n,) array_like
        Values of the runs.
    share : float
        0.5 for the median, 0.95 for the 95th percentile.
    factors : (n,) array_like
        As of `mean_interval`.

    """
    y = np.sort(np.asarray(values, dtype=np.float64))
    if len(y) < 2:
        return NO_INTERVAL
    worth = effective_runs(np.asarray(values) <= np.quantile(y, share), *factors)
    low, high = (
        _order_statistic(y, _place(share, worth, chance), worth) for chance in (_UPPER, 1.0 - _UPPER)
    )
    return Interval(low, high, "order statistics")


def effective_runs(truths: ArrayLike, *factors: ArrayLike) -> float:
    """Return the number of independent runs that give a share as sharply as these runs (Korn, Graubard)."""
    y = np.asarray(truths, dtype=np.float64)
    n, share = len(y), float(y.mean())
    codes = _crossed(n, factors)
    if any(counts == n for counts in _sizes(codes)) and len(codes) == 1:
        return float(n)
    if share in (0.0, 1.0):
        return float(min(_sizes(codes)))
    spread = spread_of_mean(y, *factors)
    if spread is None:
        return 1.0
    inflation = max(1.0, spread.error**2 * n / (share * (1.0 - share)))
    few = (float(ndtri(_UPPER)) / float(stdtrit(spread.dof, _UPPER))) ** 2
    return max(1.0, few * n / inflation)


def spread_of_mean(values: FloatArray, *factors: ArrayLike) -> Spread | None:
    """Return the spread of the mean over clusters; None with a single cluster."""
    codes = _crossed(len(values), factors)
    if not len(values) or min(_sizes(codes)) < 2:
        return None
    parts = (values - values.mean()) / len(values)
    unit = float(np.abs(parts).max()) or 1.0
    if len(codes) == 1:
        sums = _sums(parts / unit, codes[0])
        variance, dof, third = _variance(sums), len(sums) - 1.0, _third(sums)
    else:
        variance, dof, third = _crossed_moments(_table_of(parts / unit, *codes))
    return Spread(unit * variance**0.5, dof, third / variance**1.5 if variance > 0.0 else 0.0)


def _crossed_moments(parts: FloatArray) -> tuple[float, float, float]:
    """Return variance, degrees of freedom and third central moment of the mean from the (A, B) sums Z."""
    rows, columns = parts.sum(axis=1), parts.sum(axis=0)
    dofs = np.array([len(rows) - 1.0, len(columns) - 1.0])
    rest = parts - rows[:, np.newaxis] / parts.shape[1] - columns / parts.shape[0]
    both, shared = np.array([_variance(rows), _variance(columns)]), (rest**2).sum() * parts.size / dofs.prod()
    variance = both.sum() - shared
    scale = (both**2 / dofs).sum() + shared**2 / dofs.prod()
    dof = max(float(variance**2 / scale), float(dofs.min())) if scale > 0.0 else float(dofs.min())
    return float(max(variance, both.max())), dof, _third(rows) + _third(columns)


def _crossed(n: int, factors: tuple[ArrayLike, ...]) -> list[IntArray]:
    """Return the factors with two clusters or more, as whole numbers from 0; the runs if there is none."""
    codes = [np.unique(np.asarray(factor), return_inverse=True)[1] for factor in factors]
    return [code for code in codes if code.max(initial=0) > 0] or ([codes[0]] if codes else [np.arange(n)])


def _sizes(codes: list[IntArray]) -> list[int]:
    return [int(code.max(initial=-1)) + 1 for code in codes]


def _table_of(parts: FloatArray, rows: IntArray, columns: IntArray) -> FloatArray:
    n_rows, n_columns = _sizes([rows, columns])
    return _sums(parts, rows * n_columns + columns, n_rows * n_columns).reshape(n_rows, n_columns)


def _sums(parts: FloatArray, places: IntArray, count: int = 0) -> FloatArray:
    return np.bincount(places, parts, count).astype(np.float64)


def _variance(sums: FloatArray) -> float:
    return float((sums**2).sum()) * len(sums) / (len(sums) - 1.0)


def _third(sums: FloatArray) -> float:
    """Return the part of a factor in the third central moment of the mean; 0 with too few clusters."""
    n = len(sums)
    return 0.0 if n < SKEWNESS_FROM else float((sums**3).sum()) * n * n / ((n - 1.0) * (n - 2.0))


def _hall(mean: float, spread: Spread) -> tuple[float, float]:
    """Return the interval by the inverse of Hall's transformation t + a t^2 / 3 + a^2 t^3 / 27 + a / 6."""
    a, t = spread.skewness, float(stdtrit(spread.dof, _UPPER))

    def inverse(u: float) -> float:
        y = u - a / 6.0
        return y if abs(a) < 1e-6 else 3.0 / a * (float(np.cbrt(1.0 + a * y)) - 1.0)

    return mean - inverse(t) * spread.error, mean - inverse(-t) * spread.error


@lru_cache(maxsize=4096)
def _place(share: float, worth: float, chance: float) -> float:
    """Return the share u at which a fractional order statistic exceeds the percentile with 1 - `chance`."""

    def excess(u: float) -> float:
        return float(betainc((worth + 1.0) * u, (worth + 1.0) * (1.0 - u), share)) - chance

    return float(brentq(excess, 1e-12, 1.0 - 1e-12))


def _order_statistic(ordered: FloatArray, place: float, worth: float) -> float | None:
    """Return the interpolated order statistic at a share; None outside those of `worth` runs."""
    if not 1.0 <= place * (worth + 1.0) <= worth:
        return None
    position = place * (len(ordered) + 1.0) - 1.0
    return float(np.interp(position, np.arange(len(ordered)), ordered))
