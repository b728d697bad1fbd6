"""
Adaptive line of sight: the crab angle is estimated from the cross-track error.

    beta' = gamma Delta / sqrt(Delta^2 + y_e^2) y_e,   |beta| <= beta_max

(Fossen & Aguiar 2024, "A uniform semiglobal exponential stable adaptive line-of-sight (ALOS) guidance law for
3-D path following", Automatica 163). It converges for a constant crab angle. On a circle the crab angle turns
with the path, and the estimate lags behind it. Linearised, y_e has s^2 + (U / Delta) s + U gamma, critically
damped for gamma = U / (4 Delta^2). The estimate rests while the vehicle is far from the path or across it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_control.guidance.crab import CrabLaw, CrabView
from auv_core.geometry import clipped
from auv_core.integrate import State
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """The default gain is critically damped at 1.5 m/s."""

    lookahead_m: float = param("lookahead distance Delta (m)", default=15.0, above=0.0, maximum=1e4)
    gain_radpms: float = param("adaptation gain gamma (rad/(m s))", default=1.5 / 900.0, above=0.0)
    beta_max_rad: float = param("largest estimate beta_max (rad)", default=0.6, above=0.0, maximum=1.5)
    adapts_within: float = param(
        "largest cross-track error with adaptation, in lookahead distances", default=3.0, above=0.0
    )
    adapts_within_rad: float = param(
        "largest course error with adaptation (rad)", default=math.radians(40.0), above=0.0
    )


class Crab(CrabLaw):
    """The state is the estimate (rad)."""

    def __init__(self, params: Params, period_s: float) -> None:
        self.lookahead_m = params.lookahead_m
        self._params = params
        self._period_s = period_s

    def initial_state(self, view: CrabView) -> State:
        """Return zero."""
        return (0.0,)

    def step(self, state: State, view: CrabView) -> tuple[float, State]:
        """Return the estimate (rad)."""
        (beta,) = state
        p, error_m = self._params, view.cross_track_m
        if (
            abs(error_m) < p.adapts_within * p.lookahead_m
            and abs(view.course_error_rad) < p.adapts_within_rad
        ):
            rate = p.gain_radpms * p.lookahead_m / math.hypot(p.lookahead_m, error_m) * error_m
            beta = clipped(beta + self._period_s * rate, p.beta_max_rad)
        return beta, (beta,)
