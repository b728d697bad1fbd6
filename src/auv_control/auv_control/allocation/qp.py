"""The forces whose wrench is nearest to the one asked for, by a quadratic program within the limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from auv_control.allocation import Forces, ThrusterAllocator
from auv_control.allocation._box_least_squares import put_minimum
from auv_control.allocation._linear import put_clipped, put_product
from auv_core.compiled import entry, fastest
from auv_core.messages import Vec6
from auv_core.params import param
from auv_core.thrusters import Thrusters

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Params:
    """What the forces themselves cost beside the error of the wrench."""

    effort: float = param(
        "weight of the sum of the squared forces, beside the squared error of the wrench",
        default=1e-6,
        above=0.0,
    )


@entry("void(float64[:, ::1], float64[:, ::1], float64[:, ::1], TUPLE6, float64[:, ::1])")
def put_nearest_forces(gain: Floats, H: Floats, B: Floats, tau: Vec6, forces_and_limits: Floats) -> None:
    """
    Write the forces into the first row of `forces_and_limits`, (3, n), whose others are the limits (N).

    Parameters
    ----------
    gain, B : (n, 6) array
        Forces without limits are gain tau; the linear term of the objective is B tau.
    H : (n, n) array
        Quadratic term of the objective.
    tau : (6,) tuple
        Wrench to reach (N, N m; body).
    forces_and_limits : (3, n) array
        Forces, lowest and highest forces.

    """
    forces, lowest, highest = forces_and_limits[0], forces_and_limits[1], forces_and_limits[2]
    put_product(gain, tau, forces)
    if put_clipped(lowest, highest, forces):
        b = np.zeros(len(forces))
        put_product(B, tau, b)
        put_minimum(H, b, lowest, highest, forces)


class Allocator(ThrusterAllocator):
    """
    f minimises |W (T f - tau)|^2 + e |f|^2 within the limits.

    W is diag(1, 1, 1, 1/l, 1/l, 1/l) with the thrusters' `moment_arm_m` l, and e the `effort`. If the limits
    allow the least-norm forces for a wrench, the answer is these, but for a part of about e. If not, the
    search starts at the clipped forces and only lowers the objective.

    Source: Johansen and Fossen 2013, Control allocation - a survey, Automatica 49, section 2.3.
    """

    def __init__(self, params: Params, thrusters: Thrusters, lost: tuple[int, ...] = ()) -> None:
        T, n = thrusters.matrix(lost), thrusters.count
        weights = np.array([1.0] * 3 + [1.0 / thrusters.moment_arm_m**2] * 3)
        weighted = T.T * weights
        self._H = weighted @ T + params.effort * np.eye(n)
        self._B = np.ascontiguousarray(weighted)
        self._gain = np.linalg.solve(self._H, self._B)
        idle = ~T.any(axis=0)
        lowest_n, highest_n = np.where(idle, 0.0, (thrusters.lowest_n, thrusters.highest_n))
        self._rows = np.array([np.zeros(n), lowest_n, highest_n])
        self._put = fastest(put_nearest_forces)

    def forces_n(self, tau: Vec6) -> Forces:
        """Return the forces (N) for a wrench (N, N m; body)."""
        self._put(self._gain, self._H, self._B, tau, self._rows)
        return tuple(self._rows[0].tolist())
