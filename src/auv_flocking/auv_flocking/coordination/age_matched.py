"""
A proportional law whose gain falls with the age of its information.

    v_c = -k (gamma_i - mean_j gamma_hat_j),     k = min(k_max, phi / A)

A is the largest age of a packet, or its average over the last minutes if that is larger. It is the idea of
the flocking law `communication_aware`; along a path `reference_consensus` is better at every age.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from auv_core.geometry import clipped
from auv_core.integrate import State
from auv_core.params import param
from auv_flocking.coordination import CoordinationLaw, LanePlace, Pace
from auv_flocking.coordination._prediction import mean_ahead_m
from auv_flocking.lanes.status import LaneNeighbour, LaneStatus


@dataclass(frozen=True)
class Params:
    """Gains, limit and memory."""

    correction_max_mps: float = param("largest correction (m/s)", default=0.4, above=0.0, maximum=10.0)
    gain_max_ps: float = param("largest gain k_max (1/s)", default=0.1, above=0.0)
    lag_budget: float = param("largest product phi of gain and age", default=0.3, above=0.0)
    age_memory_s: float = param("time over which the age is averaged (s)", default=120.0, above=0.0)


class Coordination(CoordinationLaw):
    """The state is the average of the largest age (s)."""

    def __init__(self, params: Params, pace: Pace) -> None:
        self._params, self._pace = params, pace
        self._share = min(pace.period_s / params.age_memory_s, 1.0)

    def begin(self, own: LanePlace) -> State:
        """Return an average of zero."""
        return (0.0,)

    def hear(self, state: State, own: LanePlace, other: LaneNeighbour) -> State:
        """Return the state as it is: only ages count."""
        return state

    def step(self, state: State, own: LanePlace, others: Sequence[LaneNeighbour]) -> tuple[float, State]:
        """Return v_c (m/s)."""
        p, (usual_s,) = self._params, state
        age_s = max([own.t_s - other.time_s for other in others], default=0.0)
        usual_s += self._share * (age_s - usual_s)
        gain_ps = min(p.gain_max_ps, p.lag_budget / max(age_s, usual_s, self._pace.period_s))
        error_m = mean_ahead_m(own, others, self._pace)
        return clipped(-gain_ps * error_m, p.correction_max_mps), (usual_s,)

    def reference_m(self, state: State, own: LanePlace) -> float:
        """Return gamma - v_L t (m), which no vehicle uses."""
        return own.gamma_m - self._pace.speed_mps * own.t_s

    def predicted_m(self, sent: LaneStatus, sent_s: float, t_s: float) -> float:
        """Return the gamma that was sent, moved on at v_L (m)."""
        return sent.gamma_m + self._pace.speed_mps * (t_s - sent_s)
