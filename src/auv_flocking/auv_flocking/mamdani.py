"""
Mamdani inference with five triangular sets on one input and one output, thesis section 6.5, Eqs.
(6.32)-(6.33).

Sets NB, N, Z, P, PB are triangles between the peaks of their neighbours; "if the input is NB, so is the
output", and so on for all five; min implication, max aggregation, centre of gravity. scikit-fuzzy gives the
membership functions and the centre of gravity. Inference takes about 100 microseconds, so a `Curve`
tabulates it once in every interval between input peaks and interpolates. The points are denser near the
peaks, where a set that starts to apply moves the centre of gravity fastest.

If the output peaks are evenly spaced, the curve never decreases. Otherwise it can decrease by a few
thousandths of its range.
"""

from __future__ import annotations

from bisect import bisect_right
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import inner

Peaks = tuple[float, float, float, float, float]

SETS = ("NB", "N", "Z", "P", "PB")
FINE_STEPS = 64


def check_peaks(name: str, peaks: Peaks) -> None:
    """Raise ValueError unless the five peaks ascend."""
    if any(low >= high for low, high in pairwise(peaks)):
        raise ValueError(f"{name}: {list(peaks)} is not allowed; allowed: five ascending numbers")


def infer(x: float, input_peaks: Peaks, output_peaks: Peaks) -> float:
    """
    Return the crisp output for a crisp input by direct inference.

    Parameters
    ----------
    x : float
        Input; beyond the outer peaks the outer sets apply fully.
    input_peaks, output_peaks : (5,) tuple
        Peaks of NB, N, Z, P, PB in the units of input and output, ascending.

    """
    from skfuzzy.defuzzify import defuzz

    within = min(max(x, input_peaks[0]), input_peaks[4])
    degrees = [float(degree) for degree in _memberships(np.array([within]), input_peaks)[:, 0]]
    universe = _corners(degrees, output_peaks)
    implied = np.minimum(np.array(degrees)[:, np.newaxis], _memberships(universe, output_peaks))
    return float(defuzz(universe, implied.max(axis=0), "centroid"))


@inner
def interpolated(x: float, table: NDArray[np.float64]) -> float:
    """Return the output at an input from a curve's table; beyond the table the output is constant."""
    count = len(table) // 2
    if x < table[0]:
        return float(table[count])
    if x >= table[count - 1]:
        return float(table[2 * count - 1])
    low, high = 0, count - 1
    while high - low > 1:
        middle = (low + high) // 2
        if x < table[middle]:
            high = middle
        else:
            low = middle
    x0, x1 = float(table[low]), float(table[high])
    y0, y1 = float(table[count + low]), float(table[count + high])
    return y0 + (x - x0) * (y1 - y0) / (x1 - x0)


class Curve:
    """
    Output against input, tabulated with `steps` steps between input peaks.

    With `FINE_STEPS`, `at` agrees with `infer` to 2e-4 of the output's range.  `table` (2 k,) has k inputs,
    then their outputs, for `interpolated`.
    """

    def __init__(self, input_peaks: Peaks, output_peaks: Peaks, steps_per_set: int) -> None:
        steps = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, steps_per_set, endpoint=False))
        spans = pairwise(input_peaks)
        grid = np.concatenate([*(low + (high - low) * steps for low, high in spans), input_peaks[4:]])
        self._x: list[float] = grid.tolist()
        self._y = [infer(x, input_peaks, output_peaks) for x in self._x]
        areas = 0.5 * np.diff(grid) * np.add(self._y[1:], self._y[:-1])
        self._area: list[float] = [0.0, *np.cumsum(areas).tolist()]
        self.table = np.array((*self._x, *self._y))

    def at(self, x: float) -> float:
        """Return the output at an input; beyond the table it is constant."""
        return interpolated(x, self.table)

    def integral(self, x: float) -> float:
        """Return the integral of `at` from the first input peak to `x` (unit of output times of input)."""
        index = max(bisect_right(self._x, x) - 1, 0)
        return self._area[index] + 0.5 * (x - self._x[index]) * (self._y[index] + self.at(x))


@lru_cache(maxsize=256)
def curve(input_peaks: Peaks, output_peaks: Peaks, steps_per_set: int = FINE_STEPS) -> Curve:
    """Return the curve of these peaks, tabulated at the first call."""
    return Curve(input_peaks, output_peaks, steps_per_set)


def _memberships(x: NDArray[np.float64], peaks: Peaks) -> NDArray[np.float64]:
    """Return the (5, n) degrees of membership of n numbers in the five sets."""
    from skfuzzy.membership import trimf

    feet = (peaks[0], *peaks, peaks[4])
    return np.array([trimf(x, list(feet[k : k + 3])) for k in range(5)])


def _corners(degrees: list[float], peaks: Peaks) -> NDArray[np.float64]:
    """
    Return the outputs at which the aggregated set has a corner, so that its centre of gravity is exact.

    These are the peaks and, on both flanks of every triangle, the heights at which a rule cuts (where a cut
    triangle becomes flat, or a neighbour's flat top ends), and one half, where flanks cross.
    """
    heights = sorted({0.0, 0.5, 1.0, *degrees})
    spans = pairwise(peaks)
    rising = [low + height * (high - low) for low, high in spans for height in heights]
    spans = pairwise(peaks)
    falling = [high - height * (high - low) for low, high in spans for height in heights]
    return np.unique(np.array(rising + falling))
