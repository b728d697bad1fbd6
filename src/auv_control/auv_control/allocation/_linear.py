"""Forces that are a matrix times a wrench, such as the least-norm solution of T f = tau, and their limits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import entry, inlined
from auv_core.messages import Vec6

Floats = NDArray[np.float64]


def least_norm_inverse(T: Floats) -> Floats:
    """Return the Moore-Penrose inverse of a configuration matrix, (n, 6); a zero column gives a zero row."""
    inverse = np.asarray(np.linalg.pinv(T, rcond=1e-9), np.float64)
    inverse[~T.any(axis=0)] = 0.0
    return inverse


@inlined
def put_product(gain: Floats, tau: Vec6, forces: Floats) -> None:
    """Write gain tau into `forces`, (n,)."""
    for i in range(len(forces)):
        forces[i] = (
            gain[i, 0] * tau[0] + gain[i, 1] * tau[1] + gain[i, 2] * tau[2]
            + gain[i, 3] * tau[3] + gain[i, 4] * tau[4] + gain[i, 5] * tau[5]
        )  # fmt: skip


@inlined
def put_clipped(lowest: Floats, highest: Floats, forces: Floats) -> bool:
    """Clip `forces` one by one; return whether any was outside the limits."""
    was_outside = False
    for i in range(len(forces)):
        if forces[i] > highest[i]:
            forces[i], was_outside = highest[i], True
        elif forces[i] < lowest[i]:
            forces[i], was_outside = lowest[i], True
    return was_outside


@entry("void(float64[:, ::1], TUPLE6, float64[::1], float64[::1], float64[::1])", allocates=False)
def put_clipped_forces(gain: Floats, tau: Vec6, lowest: Floats, highest: Floats, forces: Floats) -> None:
    """Write gain tau, clipped one by one, into `forces`, (n,)."""
    put_product(gain, tau, forces)
    put_clipped(lowest, highest, forces)


@entry("void(float64[:, ::1], TUPLE6, float64[::1], float64[::1], float64[::1])", allocates=False)
def put_scaled_forces(gain: Floats, tau: Vec6, lowest: Floats, highest: Floats, forces: Floats) -> None:
    """Write gain tau, scaled as a whole into the limits, into `forces`, (n,)."""
    put_product(gain, tau, forces)
    share = 1.0
    for i in range(len(forces)):
        if share * forces[i] > highest[i]:
            share = highest[i] / forces[i]
        elif share * forces[i] < lowest[i]:
            share = lowest[i] / forces[i]
    for i in range(len(forces)):
        forces[i] = min(max(share * forces[i], lowest[i]), highest[i])
