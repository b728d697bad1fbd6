"""
Potential-function separation, thesis Eqs. (5.26)-(5.28).

U(r) = log(r^2 / d) + d^2 / r^2; its negative gradient for the vehicle at distance r is 2 (own - other) (d^2
- r^2) / r^4.

Deviation: printed without a cut-off the law attracts for r > d, against the text ("at a certain maximum
distance the repulsive potential becomes zero"); here it is zero for r >= d.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from auv_core.compiled import entry
from auv_core.geometry import Vec3
from auv_core.params import param
from auv_flocking.central import STRENGTH, Numbers, along
from auv_flocking.separation import CentralLaw, PotentialLaw

_NO_DIRECTION_M2 = 1e-18


@dataclass(frozen=True)
class Params:
    """The gain of the law."""

    gain: float = param("factor on the velocity (m^2/s per 1/m)", default=1.0, above=0.0)


@entry(STRENGTH)
def strength(square_m2: float, spacing_m: float, numbers: Numbers) -> float:
    """
    Return the factor on (own - other); zero at and beyond `spacing_m`, and below a nanometre, where the
    force has no direction.
    """
    if square_m2 >= spacing_m * spacing_m or square_m2 < _NO_DIRECTION_M2:
        return 0.0
    return float(numbers[0]) * 2.0 * (spacing_m * spacing_m - square_m2) / (square_m2 * square_m2)


class Separation(CentralLaw, PotentialLaw):
    """Repulsion inside the spacing distance, no force outside."""

    strength = obstacle_strength = staticmethod(strength)

    def __init__(self, params: Params) -> None:
        self._gain = params.gain
        self.numbers = self.obstacle_numbers = np.array([params.gain])

    def velocity(self, own: Vec3, other: Vec3, spacing_m: float) -> Vec3:
        """
        Return the repulsive velocity (m/s; NED).

        Parameters
        ----------
        own, other : (3,) tuple
            Positions (m; NED).
        spacing_m : float
            Safety distance d (m).

        """
        return along(own, other, spacing_m, strength, self.numbers)

    def reach_m(self, spacing_m: float) -> float:
        """Return the distance at and beyond which the law is zero (m)."""
        return spacing_m

    def potential(self, distance_m: float, spacing_m: float) -> float:
        """
        Return the potential of a pair (m^2/s), zero at and beyond the spacing; `velocity` is its negative
        gradient.

        U(r) - U(d) of thesis Eq. (5.26), whose constant term has no meaning.
        """
        if distance_m >= spacing_m:
            return 0.0
        square = (distance_m / spacing_m) ** 2
        return self._gain * (math.log(square) + 1.0 / square - 1.0) if square > 0.0 else math.inf

    def obstacle_potential(self, distance_m: float, spacing_m: float) -> float:
        """Return the same of an obstacle, which is treated as a vehicle is (m^2/s)."""
        return self.potential(distance_m, spacing_m)
