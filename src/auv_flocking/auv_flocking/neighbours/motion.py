"""
Motion model of a neighbour: constant velocity with white acceleration of spectral density q, or a velocity
that relaxes to the flock's.

State: position p (m) and velocity v (m/s), NED. With a memory T, v = w + u and du/dt = -u/T + white
acceleration, where w is the neighbour's estimate of the flock's velocity, which turns at a constant rate:
motion relative to the flock decays, so that a vehicle is not extrapolated with its gathering velocity through
half a minute of silence. Without memory (T = 0) dv/dt is the white acceleration alone. Both are discretised
exactly for any interval.

Source: Singer, Estimating optimal tracking filter performance for manned maneuvering targets (1970), one
derivative lower: an Ornstein-Uhlenbeck velocity about w.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import inner
from auv_core.geometry import Vec3, turned

Matrix = NDArray[np.float64]


def _on_every_axis(block: list[list[float]]) -> Matrix:
    """Return the (6, 6) matrix that applies the (2, 2) block to position and rate of every axis."""
    return np.asarray(np.kron(block, np.eye(3)), dtype=np.float64)


Turning = tuple[float, float, float, float]
"""A velocity (m/s; NED), and the rate at which it turns about the vertical (rad/s; from north to east)."""

_STRAIGHT_RAD = 1e-6
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


def later(flock: Turning, dt_s: float) -> Turning:
    """Return a turning velocity after `dt_s`."""
    rate_radps = flock[3]
    return (*turned((flock[0], flock[1], flock[2]), rate_radps * dt_s), rate_radps)


@inner
def _flock_after(flock: Turning, dt_s: float) -> tuple[Vec3, Vec3]:
    """Return the way of the flock in `dt_s` (m; NED), and its velocity then (m/s; NED)."""
    x, y, z, rate_radps = flock
    half_rad = 0.5 * rate_radps * dt_s
    chord = math.sin(half_rad) / half_rad if abs(half_rad) > _STRAIGHT_RAD else 1.0
    along = turned((x, y, z), half_rad)
    way = (dt_s * chord * along[0], dt_s * chord * along[1], dt_s * z)
    return way, turned((x, y, z), 2.0 * half_rad)


@inner
def flock_motion(dt_s: float, memory_s: float, flock: Turning) -> Matrix:
    """Return the term that the flock's motion adds to F x (6,)."""
    kept = math.exp(-dt_s / memory_s)
    reach_s = memory_s * (1.0 - kept)
    way, then = _flock_after(flock, dt_s)
    return np.array(
        (
            way[0] - reach_s * flock[0],
            way[1] - reach_s * flock[1],
            way[2] - reach_s * flock[2],
            then[0] - kept * flock[0],
            then[1] - kept * flock[1],
            then[2] - kept * flock[2],
        )
    )


@inner
def carried(x: Matrix, dt_s: float, memory_s: float, flock: Turning) -> tuple[Vec3, Vec3]:
    """Return position and velocity (m, m/s; NED) after `dt_s`, from a state's first six numbers."""
    px, py, pz = float(x[0]), float(x[1]), float(x[2])
    vx, vy, vz = float(x[3]), float(x[4]), float(x[5])
    if memory_s == 0.0:
        return (px + dt_s * vx, py + dt_s * vy, pz + dt_s * vz), (vx, vy, vz)
    kept = math.exp(-dt_s / memory_s)
    reach_s = memory_s * (1.0 - kept)
    ux, uy, uz = vx - flock[0], vy - flock[1], vz - flock[2]
    way, then = _flock_after(flock, dt_s)
    return (
        (px + way[0] + reach_s * ux, py + way[1] + reach_s * uy, pz + way[2] + reach_s * uz),
        (then[0] + kept * ux, then[1] + kept * uy, then[2] + kept * uz),
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
