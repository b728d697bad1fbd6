"""
Integral line of sight: the cross-track error is integrated.

    psi_ref = chi - atan((y_e + sigma y_i) / Delta),     y_i' = Delta y_e / ((y_e + sigma y_i)^2 + Delta^2)

(Borhaug, Pavlov & Pettersen 2008, "Integral LOS control for path following of underactuated marine surface
vessels in the presence of constant ocean currents", CDC 2008). The crab angle of this law is what the
integral adds, beta = atan((y_e + sigma y_i) / Delta) - atan(y_e / Delta). The denominator slows the integral
far from the path. Linearised, y_e has s^2 + (U / Delta) s + U sigma / Delta^2, critically damped for sigma =
U / 4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_control.guidance.crab import CrabLaw, CrabView
from auv_core.integrate import State
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """The default gain is critically damped at 1.5 m/s."""

    lookahead_m: float = param("lookahead distance Delta (m)", default=15.0, above=0.0, maximum=1e4)
    integral_mps: float = param("integral gain sigma (m/s)", default=0.375, above=0.0, maximum=100.0)


class Crab(CrabLaw):
    """The state is the integral y_i (s)."""

    def __init__(self, params: Params, period_s: float) -> None:
        self.lookahead_m = params.lookahead_m
        self._integral_mps = params.integral_mps
        self._period_s = period_s

    def initial_state(self, view: CrabView) -> State:
        """Return zero."""
        return (0.0,)

    def step(self, state: State, view: CrabView) -> tuple[float, State]:
        """Return what the integral adds to the angle (rad)."""
        (integral_s,) = state
        error_m, ahead_m = view.cross_track_m, self.lookahead_m
        sum_m = error_m + self._integral_mps * integral_s
        beta = math.atan(sum_m / ahead_m) - math.atan(error_m / ahead_m)
        return beta, (integral_s + self._period_s * ahead_m * error_m / (sum_m * sum_m + ahead_m * ahead_m),)
