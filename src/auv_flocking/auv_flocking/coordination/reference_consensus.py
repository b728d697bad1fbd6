"""
Consensus on a reference that does not move between packets (recommended).

    gamma_ref = v_L t + r_i,     v_c = -k (gamma_i - gamma_ref),     on a packet: r_i += a (r_j - r_i)

A vehicle follows its own reference, and changes r_i only with packets. Since r_j does not move between
packets, an old packet is not a wrong one. Averaging keeps every r in the convex hull of all r, and contracts
it for any delay and loss with which a packet gets through now and then (Bertsekas & Tsitsiklis 1989, Parallel
and Distributed Computation, ch. 7). The loop of a vehicle is local and does not depend on the channel; no
product of gain and age limits it.

A vehicle that cannot keep up says so with the rate of its gamma - v_L t, and lets r_i fall to what it
reaches. Those that hear it cap their own: r_i <= r_j + rate_j age_j, as long as the packet is recent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from auv_core.geometry import clipped
from auv_core.integrate import State
from auv_core.params import param
from auv_flocking.coordination import CoordinationLaw, LanePlace, Pace
from auv_flocking.lanes.status import LaneNeighbour, LaneStatus, apart_m


@dataclass(frozen=True)
class Params:
    """Gains, and what a vehicle does that cannot keep up."""

    correction_max_mps: float = param("largest correction (m/s)", default=0.4, above=0.0, maximum=10.0)
    gain_ps: float = param("speed per difference from the reference k (1/s)", default=0.1, above=0.0)
    averaging: float = param(
        "share a of the difference that a packet closes", default=0.5, above=0.0, maximum=1.0
    )
    ahead_max_m: float = param(
        "how far the reference of a vehicle that cannot keep up may be ahead of it (m)",
        default=2.0,
        minimum=0.0,
    )
    cap_s: float = param(
        "age up to which a packet of a vehicle that cannot keep up caps the reference (s)",
        default=200.0,
        minimum=0.0,
    )


class Coordination(CoordinationLaw):
    """The state is r (m)."""

    def __init__(self, params: Params, pace: Pace) -> None:
        self._params, self._pace = params, pace

    def begin(self, own: LanePlace) -> State:
        """Return the r at which the vehicle is where its reference is (m)."""
        return (own.gamma_m - self._pace.speed_mps * own.t_s,)

    def hear(self, state: State, own: LanePlace, other: LaneNeighbour) -> State:
        """Return r after a packet (m): it has moved towards the neighbour's."""
        (r_m,) = state
        return (r_m - self._params.averaging * apart_m(r_m, other.status.reference_m, self._pace.round_m),)

    def step(self, state: State, own: LanePlace, others: Sequence[LaneNeighbour]) -> tuple[float, State]:
        """Return v_c (m/s), and r (m), which falls only for vehicles that cannot keep up."""
        p, (r_m,) = self._params, state
        reached_m = own.gamma_m - self._pace.speed_mps * own.t_s
        if own.is_limited:
            r_m = min(r_m, reached_m + p.ahead_max_m)
        for other in others:
            age_s = own.t_s - other.time_s
            if other.status.is_limited and age_s <= p.cap_s:
                cap_m = other.status.reference_m + other.status.reference_rate_mps * age_s
                r_m -= max(apart_m(r_m, cap_m, self._pace.round_m), 0.0)
        return clipped(-p.gain_ps * (reached_m - r_m), p.correction_max_mps), (r_m,)

    def reference_m(self, state: State, own: LanePlace) -> float:
        """Return r (m)."""
        return state[0]

    def predicted_m(self, sent: LaneStatus, sent_s: float, t_s: float) -> float:
        """Return v_L t + r of the packet (m)."""
        return self._pace.speed_mps * t_s + sent.reference_m
