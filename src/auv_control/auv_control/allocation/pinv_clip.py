"""The least-norm forces, each clipped at its limits: simple, and the wrench changes its direction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from auv_control.allocation import Forces, ThrusterAllocator
from auv_control.allocation._linear import least_norm_inverse, put_clipped_forces
from auv_core.compiled import fastest
from auv_core.messages import Vec6
from auv_core.thrusters import Thrusters


@dataclass(frozen=True)
class Params:
    """No parameters."""


class Allocator(ThrusterAllocator):
    """
    f = clip(T^+ tau), with the Moore-Penrose inverse T^+.

    Source: Fossen 2021, Handbook of Marine Craft Hydrodynamics and Motion Control, chapter 11.
    """

    def __init__(self, _params: Params, thrusters: Thrusters, lost: tuple[int, ...] = ()) -> None:
        self._gain = np.ascontiguousarray(least_norm_inverse(thrusters.matrix(lost)))
        self._lowest_n, self._highest_n = thrusters.lowest_n, thrusters.highest_n
        self._forces_n = np.zeros(thrusters.count)
        self._put = fastest(put_clipped_forces)

    def forces_n(self, tau: Vec6) -> Forces:
        """Return the forces (N) for a wrench (N, N m; body)."""
        self._put(self._gain, tau, self._lowest_n, self._highest_n, self._forces_n)
        return tuple(self._forces_n.tolist())
