"""
The unscented Kalman filter of filterpy: a sonar contact is not linearised, but predicted for sigma points.

Source: Julier, Uhlmann, Unscented filtering and nonlinear estimation (2004); van der Merwe, Sigma-point
Kalman filters for probabilistic inference in dynamic state-space models (2004), for the scaled points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter
from numpy.typing import NDArray

from auv_core.params import param
from auv_flocking.estimators import Motion, NeighbourEstimator, Updated
from auv_flocking.estimators.filterpy_ekf import models
from auv_flocking.neighbours.sonar_contact import Sighting

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Params:
    """The spread of the sigma points."""

    alpha: float = param("spread of the sigma points about the mean", default=0.5, above=0.0, maximum=1.0)
    beta: float = param("knowledge of the distribution; 2 for a Gaussian one", default=2.0, minimum=0.0)
    kappa: float = param("secondary spread", default=0.0, minimum=0.0)


def _root(P: Matrix) -> Matrix:
    """Return U with U^T U = P, also for a P that is only semi-definite: a new offset is known exactly."""
    squares, directions = np.linalg.eigh(P)
    return np.asarray((directions * np.sqrt(np.maximum(squares, 0.0))).T)


class Estimator(NeighbourEstimator):
    """filterpy's predict and update, on an object of its own for every call."""

    def __init__(self, params: Params) -> None:
        self._params = params

    def predicted(self, x: Matrix, P: Matrix, motion: Motion) -> tuple[Matrix, Matrix]:
        """Return x and P after an interval."""
        F, Q, carried = models(len(x), motion)
        ukf = self._filter(x, P, 1, lambda state: state)
        ukf.Q = Q
        ukf.predict(dt=motion.dt_s, fx=lambda state, _: F @ state + carried)
        return ukf.x, ukf.P

    def updated(self, x: Matrix, P: Matrix, innovation: Matrix, H: Matrix, R: Matrix) -> Updated:
        """Return the estimate after a linear measurement."""
        return self._measured(x, P, innovation, lambda state: H @ (state - x), R)

    def seen(self, x: Matrix, P: Matrix, sighting: Sighting) -> Updated:
        """Return the estimate after a sonar contact."""
        return self._measured(x, P, np.zeros(3), lambda state: sighting.beside(state[:3]), sighting.noise)

    def _measured(
        self, x: Matrix, P: Matrix, z: Matrix, measure: Callable[[Matrix], Matrix], R: Matrix
    ) -> Updated:
        ukf = self._filter(x, P, len(z), measure)
        ukf.sigmas_f = ukf.points_fn.sigma_points(ukf.x, ukf.P)
        ukf.update(z, R=R)
        symmetric = 0.5 * (ukf.P + ukf.P.T)
        return Updated(ukf.x, symmetric, ukf.y, ukf.SI)

    def _filter(self, x: Matrix, P: Matrix, numbers: int, measure: Callable[[Matrix], Matrix]) -> Any:
        """Return filterpy's filter for this estimate and a measurement of so many numbers."""
        p, size = self._params, len(x)
        points = MerweScaledSigmaPoints(size, p.alpha, p.beta, p.kappa, sqrt_method=_root)
        ukf = UnscentedKalmanFilter(size, numbers, 0.0, measure, lambda state, _: state, points)
        ukf.x, ukf.P = x.copy(), P.copy()
        return ukf
