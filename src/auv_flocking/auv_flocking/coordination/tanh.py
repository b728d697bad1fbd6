"""
The law of the Farol stack, for comparison.

    v_c = -v_max tanh((gamma_i - mean_j gamma_hat_j) / slope),     gamma_hat_j = gamma_j + v_L (t - t_j)

(event-triggered coordination of path parameters in Farol, the software of DSOR, Lisbon; after Rego et al.
2019, "Cooperative path-following control with logic-based communications"). The prediction of a neighbour is
wrong by what it has corrected since its packet, so that old packets disturb.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from auv_core.integrate import State
from auv_core.params import param
from auv_flocking.coordination import CoordinationLaw, LanePlace, Pace
from auv_flocking.coordination._prediction import mean_ahead_m
from auv_flocking.lanes.status import LaneNeighbour, LaneStatus


@dataclass(frozen=True)
class Params:
    """Limit and slope."""

    correction_max_mps: float = param("largest correction v_max (m/s)", default=0.4, above=0.0, maximum=10.0)
    slope_m: float = param("difference of path parameters at tanh(1) (m)", default=1.0, above=0.0)


class Coordination(CoordinationLaw):
    """A law without state."""

    def __init__(self, params: Params, pace: Pace) -> None:
        self._params, self._pace = params, pace

    def begin(self, own: LanePlace) -> State:
        """Return nothing."""
        return ()

    def hear(self, state: State, own: LanePlace, other: LaneNeighbour) -> State:
        """Return nothing."""
        return ()

    def step(self, state: State, own: LanePlace, others: Sequence[LaneNeighbour]) -> tuple[float, State]:
        """Return v_c (m/s)."""
        error_m = mean_ahead_m(own, others, self._pace)
        return -self._params.correction_max_mps * math.tanh(error_m / self._params.slope_m), ()

    def reference_m(self, state: State, own: LanePlace) -> float:
        """Return gamma - v_L t (m), which no vehicle uses."""
        return own.gamma_m - self._pace.speed_mps * own.t_s

    def predicted_m(self, sent: LaneStatus, sent_s: float, t_s: float) -> float:
        """Return the gamma that was sent, moved on at v_L (m)."""
        return sent.gamma_m + self._pace.speed_mps * (t_s - sent_s)
