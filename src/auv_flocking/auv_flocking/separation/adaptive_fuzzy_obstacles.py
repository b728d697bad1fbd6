"""
Adaptive fuzzy separation for waters with obstacles (future work of thesis section 7.3).

Vehicles are kept apart as by ``adaptive_fuzzy``. That law meets obstacles with peaks at rest: at an
obstacle's safety distance d_o it does not repel, so the attraction in a flock brings vehicles nearer than
d_o. Here the output peaks for obstacles move too, by s_o,

    s_o_dot = obstacle_rate * clip(mean of (r_o - d_o), +-error_max),   -obstacle_shift_max <= s_o <= 0,

over the obstacles within `obstacle_reach_m` of their safety distance. Inside d_o this adds repulsion until it
balances the attraction; outside it takes repulsion away. Where no obstacle is within reach, s_o goes back to
zero at the rate `forgetting_ps`, since the next obstacle is met under other forces.

* An obstacle only repels: the law is zero where curve and shift together would attract. With s_o < 0 this is
  farther away than d_o, so that the push grows from zero and not in a step.
* Distances to an obstacle are never held from outside: s_o <= 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from auv_core.compiled import entry
from auv_core.geometry import Vec3
from auv_core.params import param
from auv_flocking.central import STRENGTH, Numbers, along
from auv_flocking.separation import ObstacleLearningLaw, adaptive_fuzzy
from auv_flocking.separation.fuzzy import strength


@dataclass(frozen=True)
class Params(adaptive_fuzzy.Params):
    """Those of `adaptive_fuzzy`, and the motion of the output peaks for obstacles."""

    obstacle_rate_ps2: float = param(
        "speed of the obstacles' peaks per metre of distance error (1/s^2)", default=0.3, minimum=0.0
    )
    obstacle_reach_m: float = param(
        "largest distance beyond the safety distance at which an obstacle counts (m)", default=1.0, above=0.0
    )
    obstacle_shift_max_mps: float = param(
        "largest movement of the obstacles' peaks (m/s for unit gain)", default=1.5, above=0.0
    )
    forgetting_ps: float = param(
        "rate at which the movement decays without obstacles (1/s)", default=0.05, minimum=0.0
    )


@entry(STRENGTH)
def repelling(square_m2: float, spacing_m: float, numbers: Numbers) -> float:
    """Return the factor of `strength`, zero where it would attract."""
    return max(strength(square_m2, spacing_m, numbers), 0.0)


class Separation(adaptive_fuzzy.Separation, ObstacleLearningLaw):
    """Repulsion of vehicles and obstacles that adapts until both keep their distances."""

    obstacle_strength = staticmethod(repelling)

    def __init__(self, params: Params) -> None:
        super().__init__(params)
        self._obstacle_params = params

    @property
    def obstacle_shift_mps(self) -> float:
        """Shift of the output peaks for obstacles (m/s for unit gain)."""
        return float(self.obstacle_numbers[1])

    def obstacle_velocity(self, own: Vec3, obstacle: Vec3, spacing_m: float) -> Vec3:
        """Return the velocity because of an obstacle (m/s; NED), away from it only."""
        return along(own, obstacle, spacing_m, repelling, self.obstacle_numbers)

    def adapt_to_obstacles(self, errors_m: Sequence[float], dt_s: float) -> None:
        """Move the peaks for one control period with the distances beyond the safety distances (m)."""
        p = self._obstacle_params
        near_m = [error_m for error_m in errors_m if error_m < p.obstacle_reach_m]
        if near_m:
            error_m = min(max(sum(near_m) / len(near_m), -p.error_max_m), p.error_max_m)
            moved_mps = self.obstacle_shift_mps + dt_s * p.obstacle_rate_ps2 * error_m
        else:
            moved_mps = self.obstacle_shift_mps * math.exp(-p.forgetting_ps * dt_s)
        self.obstacle_numbers[1] = min(max(moved_mps, -p.obstacle_shift_max_mps), 0.0)
