"""
The extended Kalman filter of filterpy, with the same models as `ekf`: the same numbers from another hand.

It is there to check `ekf` in flight, not to be fast.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter
from numpy.typing import NDArray

from auv_flocking.estimators import Motion, NeighbourEstimator, Updated, linearised
from auv_flocking.neighbours.motion import flock_motion, process_noise, transition_matrix
from auv_flocking.neighbours.navigation_offset import offset_noise, offset_transition
from auv_flocking.neighbours.sonar_contact import Sighting

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


def models(size: int, motion: Motion) -> tuple[Matrix, Matrix, Matrix]:
    """Return F (n, n), Q (n, n) and the flock's own motion (n,) for a state of n numbers."""
    dt_s, memory_s = motion.dt_s, motion.memory_s
    carried = np.zeros(size)
    if memory_s > 0.0:
        carried[:6] = flock_motion(dt_s, memory_s, motion.flock)
    if size == 6:
        return transition_matrix(dt_s, memory_s), process_noise(dt_s, motion.psd, memory_s), carried
    noise = offset_noise(dt_s, motion.psd, motion.rate_psd, memory_s)
    return offset_transition(dt_s, memory_s), noise, carried


class Estimator(NeighbourEstimator):
    """filterpy's predict and update, on an object of its own for every call."""

    def __init__(self, params: Params) -> None:
        del params

    def predicted(self, x: Matrix, P: Matrix, motion: Motion) -> tuple[Matrix, Matrix]:
        """Return x and P after an interval."""
        ekf = ExtendedKalmanFilter(dim_x=len(x), dim_z=1)
        ekf.x, ekf.P, ekf.B = x.copy(), P.copy(), np.eye(len(x))
        ekf.F, ekf.Q, carried = models(len(x), motion)
        ekf.predict(carried)
        return ekf.x, ekf.P

    def updated(self, x: Matrix, P: Matrix, innovation: Matrix, H: Matrix, R: Matrix) -> Updated:
        """Return the estimate after a linear measurement."""
        ekf = ExtendedKalmanFilter(dim_x=len(x), dim_z=len(innovation))
        ekf.x, ekf.P = x.copy(), P.copy()
        ekf.update(innovation, lambda _: H, lambda _: np.zeros(len(innovation)), R)
        return Updated(ekf.x, ekf.P, ekf.y, ekf.SI)

    def seen(self, x: Matrix, P: Matrix, sighting: Sighting) -> Updated:
        """Return the estimate after a sonar contact, linearised at the point that it gives."""
        return self.updated(x, P, *linearised(x, sighting), sighting.noise)
