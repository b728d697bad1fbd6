"""
Confidence intervals of paired differences: two cases that were flown with the same draws and seeds.

What a seed does to both cases alike cancels in the difference of its two runs, so that the interval of the
mean difference is often much narrower than those of the two means suggest.

Source for shares: Bonett and Price, Br. J. Math. Stat. Psychol. 65 (2012): a pair more in which only the one
case is true, and one in which only the other is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri

from auv_experiment.confidence import CONFIDENCE
from auv_experiment.confidence.clusters import NO_INTERVAL, Interval, effective_runs, mean_interval

BONETT_PRICE = "Bonett and Price"


def difference_interval(
    values: ArrayLike, others: ArrayLike, *factors: ArrayLike, is_truth: bool = False
) -> Interval:
    """
    Return the interval of mean(values) - mean(others), from the differences of pairs.

    Parameters
    ----------
    values, others : (n,) array_like
        Of the two cases, pair by pair.
    factors : (n,) array_like
        Numbers of the pairs' draws or seeds, as of `mean_interval`.
    is_truth : bool
        Whether they are truth values, so that the means are shares.

    """
    differences = np.asarray(values, dtype=np.float64) - np.asarray(others, dtype=np.float64)
    if not is_truth:
        return mean_interval(differences, *factors)
    if not len(differences):
        return NO_INTERVAL
    worth = min(effective_runs(differences == sign, *factors) for sign in (1.0, -1.0))
    gained, lost = (((differences == sign).mean() * worth + 1.0) / (worth + 2.0) for sign in (1.0, -1.0))
    middle = gained - lost
    half = float(ndtri(0.5 + 0.5 * CONFIDENCE)) * np.sqrt((gained + lost - middle**2) / (worth + 2.0))
    return Interval(float(max(middle - half, -1.0)), float(min(middle + half, 1.0)), BONETT_PRICE)
