"""
Motion model of a neighbour: constant velocity with white acceleration of spectral density q, or a velocity
that relaxes to the flock's.

State: position p (m) and velocity v (m/s), NED. With a memory T, dv/dt = -(v - w)/T + white acceleration,
where w is the neighbour's estimate of the flock's velocity: motion relative to the flock decays, so that a
vehicle is not extrapolated with its gathering velocity through half a minute of silence. Without memory (T =
0) dv/dt is the white acceleration alone. Both are discretised exactly for any interval.

Source: Singer, Estimating optimal tracking filter performance for manned maneuvering targets (1970), one
derivative lower: an Ornstein-Uhlenbeck velocity about w.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import inner
from auv_core.geometry import Vec3

Matrix = NDArray[np.float64]


def _on_every_axis(block: list[list[float]]) -> Matrix:
    """Return the (6, 6) matrix that applies the (2, 2) block to position and rate of every axis."""
    return np.asarray(np.kron(block, np.eye(3)), dtype=np.float64)


_IDENTITY = np.eye(6)
_DRIFT = _on_every_axis([[0.0, 1.0], [0.0, 0.0]])
_POSITION = _on_every_axis([[1.0, 0.0], [0.0, 0.0]])
_COUPLING = _on_every_axis([[0.0, 1.0], [1.0, 0.0]])
_VELOCITY = _on_every_axis([[0.0, 0.0], [0.0, 1.0]])


@inner
def transition_matrix(dt_s: float, memory_s: float = 0.0) -> Matrix:
    """Return F (6, 6) over `dt_s`; with a memory, for the motion relative to the flock."""
    if memory_s == 0.0:
        return _IDENTITY + dt_s * _DRIFT
    kept = math.exp(-dt_s / memory_s)
    return _IDENTITY + memory_s * (1.0 - kept) * _DRIFT + (kept - 1.0) * _VELOCITY


@inner
def process_noise(dt_s: float, acceleration_psd: float, memory_s: float = 0.0) -> Matrix:
    """
    Return Q (6, 6) of white acceleration over `dt_s`, exact; without a memory q [[dt^3/3, dt^2/2],
    [dt^2/2, dt]] on every axis.
    """
    q = acceleration_psd * dt_s
    if memory_s == 0.0:
        return (q * dt_s * dt_s / 3.0) * _POSITION + (0.5 * q * dt_s) * _COUPLING + q * _VELOCITY
    position, mixed, velocity = _noise(dt_s, memory_s)
    return acceleration_psd * (position * _POSITION + mixed * _COUPLING + velocity * _VELOCITY)


@inner
def _noise(dt_s: float, memory_s: float) -> tuple[float, float, float]:
    """Return the effect of white acceleration of density 1 on position, both, and velocity (s^3, s^2, s)."""
    if memory_s == 0.0:
        return dt_s * dt_s * dt_s / 3.0, 0.5 * dt_s * dt_s, dt_s
    kept = math.exp(-dt_s / memory_s)
    reach_s = memory_s * (1.0 - kept)
    velocity_s = 0.5 * memory_s * (1.0 - kept * kept)
    return memory_s * memory_s * (dt_s - 2.0 * reach_s + velocity_s), 0.5 * reach_s * reach_s, velocity_s


@inner
def flock_motion(dt_s: float, memory_s: float, flock_velocity: Vec3) -> Matrix:
    """Return the term that the flock's motion adds to F x (6,)."""
    kept = math.exp(-dt_s / memory_s)
    way_s = dt_s - memory_s * (1.0 - kept)
    x, y, z = flock_velocity
    left = 1.0 - kept
    return np.array((way_s * x, way_s * y, way_s * z, left * x, left * y, left * z))


@inner
def carried(x: Matrix, dt_s: float, memory_s: float, flock_velocity: Vec3) -> tuple[Vec3, Vec3]:
    """Return position and velocity (m, m/s; NED) after `dt_s`, from a state's first six numbers."""
    vx, vy, vz = float(x[3]), float(x[4]), float(x[5])
    wx, wy, wz = flock_velocity
    kept, reach_s = 1.0, dt_s
    if memory_s == 0.0:
        wx, wy, wz = 0.0, 0.0, 0.0
    else:
        kept = math.exp(-dt_s / memory_s)
        reach_s = memory_s * (1.0 - kept)
    ux, uy, uz = vx - wx, vy - wy, vz - wz
    return (
        (
            float(x[0]) + dt_s * wx + reach_s * ux,
            float(x[1]) + dt_s * wy + reach_s * uy,
            float(x[2]) + dt_s * wz + reach_s * uz,
        ),
        (wx + kept * ux, wy + kept * uy, wz + kept * uz),
    )


@inner
def grown(P: Matrix, dt_s: float, acceleration_psd: float, memory_s: float, out: Matrix) -> None:
    """
    Write F P F^T + Q after `dt_s` into `out`; both are (36,), rows of a (6, 6) one after the other.

    The product is written out for the two numbers of F, since it is computed at every tick for every
    neighbour.
    """
    kept = 1.0 if memory_s == 0.0 else math.exp(-dt_s / memory_s)
    reach_s = dt_s if memory_s == 0.0 else memory_s * (1.0 - kept)
    position, mixed, velocity = _noise(dt_s, memory_s)
    for i in range(3):
        for j in range(3):
            pp, pv = float(P[6 * i + j]), float(P[6 * i + 3 + j])
            vp, vv = float(P[6 * i + 18 + j]), float(P[6 * i + 21 + j])
            same = acceleration_psd if i == j else 0.0
            out[6 * i + j] = pp + reach_s * (pv + vp) + reach_s * reach_s * vv + same * position
            out[6 * i + 3 + j] = kept * (pv + reach_s * vv) + same * mixed
            out[6 * i + 18 + j] = kept * (vp + reach_s * vv) + same * mixed
            out[6 * i + 21 + j] = kept * kept * vv + same * velocity
