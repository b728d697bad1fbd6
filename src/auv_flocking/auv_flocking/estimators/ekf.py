"""
The extended Kalman filter, thesis Eqs. (5.29)-(5.35), compiled where the run is.

A sonar contact is linearised at the point that it gives (`auv_flocking.neighbours.sonar_contact`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import entry, fastest
from auv_flocking.estimators import Motion, NeighbourEstimator, Updated, linearised
from auv_flocking.neighbours.kalman import predicted, updated
from auv_flocking.neighbours.motion import Turning, flock_motion, process_noise, transition_matrix
from auv_flocking.neighbours.navigation_offset import offset_noise, offset_transition
from auv_flocking.neighbours.sonar_contact import Sighting

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


@entry(
    "Tuple((float64[::1], float64[:, ::1]))"
    "(float64[::1], float64[:, ::1], float64, float64, float64, float64, TUPLE4)"
)
def _ahead(
    x: Matrix, P: Matrix, dt_s: float, psd: float, rate_psd: float, memory_s: float, flock: Turning
) -> tuple[Matrix, Matrix]:
    """Return x and P after an interval, without (6,) or with (10,) the offset."""
    if len(x) == 6:
        x, P = predicted(x, P, transition_matrix(dt_s, memory_s), process_noise(dt_s, psd, memory_s))
    else:
        F, Q = offset_transition(dt_s, memory_s), offset_noise(dt_s, psd, rate_psd, memory_s)
        x, P = predicted(x, P, F, Q)
    if memory_s > 0.0:
        x[:6] += flock_motion(dt_s, memory_s, flock)
    return x, P


class Estimator(NeighbourEstimator):
    """The filter's two steps."""

    def __init__(self, params: Params) -> None:
        del params
        self._ahead, self._updated = fastest(_ahead), fastest(updated)

    def predicted(self, x: Matrix, P: Matrix, motion: Motion) -> tuple[Matrix, Matrix]:
        """Return x and P after an interval."""
        return self._ahead(x, P, *motion)

    def updated(self, x: Matrix, P: Matrix, innovation: Matrix, H: Matrix, R: Matrix) -> Updated:
        """Return the estimate after a linear measurement."""
        after, covariance, precision = self._updated(x, P, innovation, H, R)
        return Updated(after, covariance, innovation, precision)

    def seen(self, x: Matrix, P: Matrix, sighting: Sighting) -> Updated:
        """Return the estimate after a sonar contact."""
        return self.updated(x, P, *linearised(x, sighting), sighting.noise)
