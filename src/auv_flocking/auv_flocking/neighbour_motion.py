"""
How a neighbour is thought to move: constant velocity with white acceleration of spectral density q.

State: position (m) and velocity (m/s), NED.  The discretisation is exact for any interval, so that packets
may be seconds apart.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]


def _on_every_axis(block: list[list[float]]) -> Matrix:
    """Return the (6, 6) matrix that does on every axis what the (2, 2) block does to position and rate."""
    return np.asarray(np.kron(block, np.eye(3)), dtype=np.float64)


_IDENTITY = np.eye(6)
_DRIFT = _on_every_axis([[0.0, 1.0], [0.0, 0.0]])
_POSITION = _on_every_axis([[1.0, 0.0], [0.0, 0.0]])
_COUPLING = _on_every_axis([[0.0, 1.0], [1.0, 0.0]])
_VELOCITY = _on_every_axis([[0.0, 0.0], [0.0, 1.0]])


def transition_matrix(dt_s: float) -> Matrix:
    """Return F (6, 6) of the constant-velocity model over `dt_s`."""
    return _IDENTITY + dt_s * _DRIFT


def process_noise(dt_s: float, acceleration_psd: float) -> Matrix:
    """
    Return Q (6, 6) of white acceleration over `dt_s`: q [[dt^3/3, dt^2/2], [dt^2/2, dt]] on every axis,
    exact.
    """
    q = acceleration_psd * dt_s
    return (q * dt_s * dt_s / 3.0) * _POSITION + (0.5 * q * dt_s) * _COUPLING + q * _VELOCITY


def covariance_growth(covariance: Matrix, acceleration_psd: float) -> Matrix:
    """
    Return the coefficients (4, 36) of F P F^T + Q as a cubic in the interval, constant first: at every tick
    that is cheaper than the product.
    """
    drifted = _DRIFT @ covariance
    coefficients = (
        covariance,
        drifted + drifted.T + acceleration_psd * _VELOCITY,
        drifted @ _DRIFT.T + (0.5 * acceleration_psd) * _COUPLING,
        (acceleration_psd / 3.0) * _POSITION,
    )
    return np.array(coefficients).reshape(4, 36)


def grown(growth: Matrix, dt_s: float) -> Matrix:
    """Return the covariance (6, 6) after `dt_s`; the caller may keep and change it."""
    square_s2 = dt_s * dt_s
    covariance: Matrix = np.dot((1.0, dt_s, square_s2, square_s2 * dt_s), growth).reshape(6, 6)
    return covariance
