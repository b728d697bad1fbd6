"""
One step of a Kalman filter on arrays: predict, and update in Joseph form.

Source: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), section
5.2.3.  Tests compare both with filterpy.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import entry, inner

Matrix = NDArray[np.float64]


@inner
def predicted(x: Matrix, P: Matrix, F: Matrix, Q: Matrix) -> tuple[Matrix, Matrix]:
    """Return F x and F P F^T + Q."""
    return F @ x, F @ P @ F.T + Q


@entry(
    "Tuple((float64[::1], float64[:, ::1], float64[:, ::1]))"
    "(float64[::1], float64[:, ::1], float64[::1], float64[:, ::1], float64[:, ::1])"
)
def updated(x: Matrix, P: Matrix, innovation: Matrix, H: Matrix, R: Matrix) -> tuple[Matrix, Matrix, Matrix]:
    """
    Return x and P after a measurement, and the inverse of its innovation covariance.

    Parameters
    ----------
    x, P : (n,), (n, n) array
        State and covariance before it.
    innovation : (m,) array
        z - h(x).
    H, R : (m, n), (m, m) array
        Derivative of h, and covariance of the noise.

    """
    PHT = P @ H.T
    precision = np.ascontiguousarray(np.linalg.inv(H @ PHT + R))
    K = PHT @ precision
    I_KH = np.eye(len(x)) - K @ H
    return x + K @ innovation, I_KH @ P @ I_KH.T + K @ R @ K.T, precision
