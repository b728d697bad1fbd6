"""
Fuzzy separation with an adaptive repulsion (future work of thesis section 7.3).

As ``fuzzy``, but with moving output peaks. A fuzzy law with fixed peaks does not repel at the distance d, so
the attraction in a flock brings its vehicles nearer than d. How much nearer depends on the width of the sets,
and narrow sets are stiff. Here all output peaks move by s,

    s_dot = rate * clip(mean of (r_j - d), +-error_max),   |s| <= shift_max,

over the neighbours within `reach_m` of d, until the force at d balances the attraction: this is an integral
of the distance error. Distances then settle at d with wide, soft sets, which tolerate control periods of 0.1
s and the age of acoustic information.

* The peaks keep their order and spacing, so the curve keeps its shape; the centre of gravity moves with
  them, and `shift_max_mps` bounds the shift.
* Every vehicle has one s: the mean distance to its neighbours converges to d. In a regular flock of up to
  four vehicles in space, every distance does.
* s changes only while a neighbour is within reach, and is limited at its bounds; for obstacles s is 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from auv_core.geometry import Vec3
from auv_core.params import param
from auv_flocking.central import along
from auv_flocking.mamdani import Peaks, check_peaks, curve
from auv_flocking.separation import CentralLaw, LearningLaw, ObstacleLaw
from auv_flocking.separation.fuzzy import repulsion, strength


@dataclass(frozen=True)
class Params:
    """Sets, and the motion of the output peaks."""

    input_peaks_m: Peaks = param(
        "peaks of NB, N, Z, P, PB of distance minus spacing (m)", default=(-5.0, -0.5, 0.0, 0.5, 5.0)
    )
    output_peaks_mps: Peaks = param(
        "initial peaks of NB, N, Z, P, PB of the attraction (m/s for unit gain)",
        default=(-2.0, -1.0, 0.0, 1.0, 2.0),
    )
    gain: float = param("factor on the velocity", default=1.0, above=0.0)
    adaptation_rate_ps2: float = param(
        "speed of the peaks per metre of distance error (1/s^2)", default=0.1, minimum=0.0
    )
    error_max_m: float = param("limit of the distance error that moves the peaks (m)", default=0.5, above=0.0)
    reach_m: float = param("largest distance error of neighbours that count (m)", default=0.8, above=0.0)
    shift_max_mps: float = param("largest movement of the peaks (m/s for unit gain)", default=1.5, above=0.0)

    def __post_init__(self) -> None:
        """Check the order of the sets."""
        check_peaks("input_peaks_m", self.input_peaks_m)
        check_peaks("output_peaks_mps", self.output_peaks_mps)


class Separation(CentralLaw, LearningLaw, ObstacleLaw):
    """
    Repulsion within a distance that adapts until pairs settle at the spacing; `numbers` are those of `fuzzy`
    with the current shift.
    """

    strength = staticmethod(strength)
    obstacle_strength = staticmethod(repulsion)

    def __init__(self, params: Params) -> None:
        self._params = params
        self.obstacle_numbers = np.array(
            (params.gain, 0.0, *curve(params.input_peaks_m, params.output_peaks_mps).table)
        )
        self.numbers = self.obstacle_numbers.copy()

    @property
    def shift_mps(self) -> float:
        """Shift of the output peaks (m/s for unit gain)."""
        return float(self.numbers[1])

    @property
    def output_peaks_mps(self) -> Peaks:
        """The current output peaks (m/s for unit gain)."""
        peaks, s = self._params.output_peaks_mps, self.shift_mps
        return (peaks[0] + s, peaks[1] + s, peaks[2] + s, peaks[3] + s, peaks[4] + s)

    def velocity(self, own: Vec3, other: Vec3, spacing_m: float) -> Vec3:
        """
        Return the velocity along the pair (m/s; NED) with the current peaks; zero below a nanometre.

        Parameters
        ----------
        own, other : (3,) tuple
            Positions (m; NED).
        spacing_m : float
            Safety distance d (m).

        """
        return along(own, other, spacing_m, strength, self.numbers)

    def obstacle_velocity(self, own: Vec3, obstacle: Vec3, spacing_m: float) -> Vec3:
        """Return the velocity because of an obstacle (m/s; NED): with unmoved peaks, away from it only."""
        return along(own, obstacle, spacing_m, repulsion, self.obstacle_numbers)

    def reach_m(self, spacing_m: float) -> float:
        """Return infinity: the curve ends nowhere."""
        return math.inf

    def adapt(self, distances_m: Sequence[float], spacing_m: float, dt_s: float) -> None:
        """Move the peaks for one control period of `dt_s` with the distances to the neighbours (m)."""
        p = self._params
        errors_m = [distance_m - spacing_m for distance_m in distances_m]
        near_m = [error_m for error_m in errors_m if abs(error_m) < p.reach_m]
        if not near_m:
            return
        error_m = min(max(sum(near_m) / len(near_m), -p.error_max_m), p.error_max_m)
        shift_mps = self.shift_mps + dt_s * p.adaptation_rate_ps2 * error_m
        self.numbers[1] = min(max(shift_mps, -p.shift_max_mps), p.shift_max_mps)
