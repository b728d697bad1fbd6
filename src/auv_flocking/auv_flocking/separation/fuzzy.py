"""
Fuzzy separation, thesis section 6.5: Mamdani inference from the distance of a pair to a force along it.

Input r - d on [-5, 5] m, output f on [-2, 2] (positive is attraction), five triangular sets each, identity
rules, centre of gravity: thesis Eqs. (6.32)-(6.33), Fig. 6.3.  The velocity of the vehicle at `own` is -f(r -
d) (own - other) / r.

The thesis tunes the peaks "by repetitive trial and error" and prints none. The defaults give its distances:
the narrow set of zero, 0.045 m, keeps a flock near d. It also makes the law stiff, about 80 1/s for four
vehicles, which needs a control period or integration step of at most 0.02 s.

Deviation: beyond the outer peaks the output is constant.

Deviation: the thesis uses the same law for obstacles, which would attract a flock to every obstacle nearby;
here an obstacle only repels, and `obstacles: printed` is the thesis's law.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from auv_core.compiled import entry
from auv_core.geometry import Vec3
from auv_core.params import param
from auv_flocking.central import STRENGTH, Numbers, along
from auv_flocking.mamdani import Peaks, check_peaks, curve, interpolated
from auv_flocking.separation import CentralLaw, ObstacleLaw, PotentialLaw

_NO_DIRECTION_M = 1e-9


@dataclass(frozen=True)
class Params:
    """The defaults give the distances of the thesis's Table 6.1."""

    input_peaks_m: Peaks = param(
        "peaks of NB, N, Z, P, PB of distance minus spacing (m)", default=(-5.0, -0.045, 0.0, 0.045, 5.0)
    )
    output_peaks_mps: Peaks = param(
        "peaks of NB, N, Z, P, PB of the attraction (m/s for unit gain)", default=(-2.0, -1.0, 0.0, 1.0, 2.0)
    )
    gain: float = param("factor on the velocity", default=1.0, above=0.0)
    obstacles: str = param(
        "whether obstacles only repel, or attract at long range as printed",
        default="repel",
        choices=("repel", "printed"),
    )

    def __post_init__(self) -> None:
        """Check the order of the sets."""
        check_peaks("input_peaks_m", self.input_peaks_m)
        check_peaks("output_peaks_mps", self.output_peaks_mps)


@entry(STRENGTH)
def strength(square_m2: float, spacing_m: float, numbers: Numbers) -> float:
    """
    Return the factor on (own - other) by `numbers`: gain, shift of the output, table of the curve; zero
    below a nanometre, where the force has no direction.
    """
    distance_m = math.sqrt(square_m2)
    if distance_m < _NO_DIRECTION_M:
        return 0.0
    attraction_mps = interpolated(distance_m - spacing_m, numbers[2:]) + float(numbers[1])
    return -float(numbers[0]) * attraction_mps / distance_m


@entry(STRENGTH)
def repulsion(square_m2: float, spacing_m: float, numbers: Numbers) -> float:
    """Return the factor of `strength`, zero at and beyond the spacing."""
    if square_m2 >= spacing_m * spacing_m:
        return 0.0
    return strength(square_m2, spacing_m, numbers)


class Separation(CentralLaw, ObstacleLaw, PotentialLaw):
    """Repulsion inside the spacing distance, attraction outside."""

    strength = staticmethod(strength)

    def __init__(self, params: Params) -> None:
        self._curve = curve(params.input_peaks_m, params.output_peaks_mps)
        self._gain = params.gain
        self._only_repels = params.obstacles == "repel"
        self.obstacle_strength = repulsion if self._only_repels else strength
        self.numbers = self.obstacle_numbers = np.array((params.gain, 0.0, *self._curve.table))

    def velocity(self, own: Vec3, other: Vec3, spacing_m: float) -> Vec3:
        """
        Return the velocity along the pair (m/s; NED).

        Parameters
        ----------
        own, other : (3,) tuple
            Positions (m; NED).
        spacing_m : float
            Safety distance d (m).

        """
        return along(own, other, spacing_m, strength, self.numbers)

    def obstacle_velocity(self, own: Vec3, obstacle: Vec3, spacing_m: float) -> Vec3:
        """Return the velocity because of an obstacle (m/s; NED): as `velocity`, away from it only."""
        return along(own, obstacle, spacing_m, self.obstacle_strength, self.numbers)

    def reach_m(self, spacing_m: float) -> float:
        """Return infinity: the curve ends nowhere."""
        return math.inf

    def potential(self, distance_m: float, spacing_m: float) -> float:
        """
        Return the potential of a pair (m^2/s), zero at the spacing; `velocity` is its negative gradient.
        """
        of_curve = self._curve.integral
        return self._gain * (of_curve(distance_m - spacing_m) - of_curve(0.0))

    def obstacle_potential(self, distance_m: float, spacing_m: float) -> float:
        """Return the potential of an obstacle (m^2/s); `obstacle_velocity` is its negative gradient."""
        if self._only_repels and distance_m >= spacing_m:
            return 0.0
        return self.potential(distance_m, spacing_m)
