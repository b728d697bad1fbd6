"""
Proportional dynamic-average consensus, thesis Eqs. (5.10)-(5.11) and (6.4)-(6.5).

    c_i_dot = k [(eta_i - c_i) + sum_j a_ij (c_j - c_i)],       together  c_dot = k [-(L + I) c + eta]

For vehicles at rest c -> (L + I)^-1 eta: the mean of the estimates is exact, each estimate is biased towards
its own vehicle (on a complete graph of n by (eta_i - mean) / (n + 1)).  The proof (6.7)-(6.18) bounds the
error, V_dot <= -|e|^2 + |e| n rho; it does not make it vanish, and neither does the filter.

A packet is carried on to now with the rate that it states.  With c_dot as that rate and news of age tau a
mode of the weights' eigenvalue a has s + k (n - a (1 + s tau) exp(-s tau)) = 0 on a complete graph: a neutral
delay equation, whose fast modes grow without bound where k (n - 1) tau > 1: from 0.33 s on for four vehicles
and k = 1.  `carried_by: flock` states the flock's velocity instead (zero without `follow_flock`); the filter
is then a chain of weighted means and stable with news of any age.

Deviation: `follow_flock` adds the flock's velocity to every c_i_dot, which takes away the lag of 1 / k
behind a moving flock.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from auv_core.compiled import inlined
from auv_core.geometry import Vec3
from auv_core.params import param
from auv_flocking.codec import Field
from auv_flocking.consensus import centres_within
from auv_flocking.neighbours.estimates import Neighbours


@dataclass(frozen=True)
class Params:
    """The defaults are the thesis's filter."""

    rate_ps: float = param("rate k of the filter (1/s)", default=1.0, above=0.0)
    reach_m: float | None = param(
        "only a vehicle nearer than this is a neighbour in the filter (m); left out: every one that is heard",
        default=None,
        above=0.0,
    )
    follow_flock: bool = param("add the flock's velocity to the estimate's rate", default=False)
    carried_by: str = param(
        "the rate that packets state, to carry the estimate on with: its own, or only the flock's velocity",
        default="rate",
        choices=("rate", "flock"),
    )

    @property
    def uses_flock_velocity(self) -> bool:
        """Whether the filter needs what packets say of the flock's velocity."""
        return self.follow_flock


@inlined
def towards(pull: Vec3, other: Vec3, centre: Vec3) -> Vec3:
    """Return what pulls the estimate `centre`, with `other` added to it (m; NED)."""
    return (
        pull[0] + other[0] - centre[0],
        pull[1] + other[1] - centre[1],
        pull[2] + other[2] - centre[2],
    )


class Consensus:
    """One vehicle's filter; in continuous time the estimate is kept by the caller."""

    shared_fields: tuple[Field, ...] = ()

    def __init__(self, params: Params, fleet_size: int) -> None:
        del fleet_size
        self.rate_ps = params.rate_ps
        self.reach_m = math.inf if params.reach_m is None else params.reach_m
        self._follow = 1.0 if params.follow_flock else 0.0
        self._states_own_rate = params.carried_by == "rate"
        self._centre: Vec3 | None = None

    def centre(self, own: Vec3, heard: Neighbours) -> Vec3:
        """Return the estimate at this control period (m; NED); the first one is the own position."""
        del heard
        if self._centre is None:
            self._centre = own
        return self._centre

    def advance(self, own: Vec3, heard: Neighbours, flock_velocity: Vec3, dt_s: float) -> Vec3:
        """Move the estimate on by `dt_s`; return the rate to carry it on with (m/s; NED)."""
        centre = self.centre(own, heard)
        centres = centres_within(self.reach_m, own, [(other.position, other.centre) for other in heard])
        rate = self.derivative(own, centre, centres, flock_velocity)
        self._centre = self.step(own, centre, centres, flock_velocity, dt_s)
        if self._states_own_rate:
            return rate
        f = self._follow
        return (f * flock_velocity[0], f * flock_velocity[1], f * flock_velocity[2])

    def shared(self) -> tuple[float, ...]:
        """Return nothing: a packet's centre is all that this filter needs."""
        return ()

    def derivative(
        self, own: Vec3, centre: Vec3, neighbour_centres: Sequence[Vec3], flock_velocity: Vec3
    ) -> Vec3:
        """Return c_i_dot (m/s; NED) for positions and estimates in NED (m)."""
        pull = towards((0.0, 0.0, 0.0), own, centre)
        for other in neighbour_centres:
            pull = towards(pull, other, centre)
        sx, sy, sz = pull
        k, f = self.rate_ps, self._follow
        return (
            k * sx + f * flock_velocity[0],
            k * sy + f * flock_velocity[1],
            k * sz + f * flock_velocity[2],
        )

    def step(
        self, own: Vec3, centre: Vec3, neighbour_centres: Sequence[Vec3], flock_velocity: Vec3, dt_s: float
    ) -> Vec3:
        """Return the estimate `dt_s` later: the exact solution for held inputs, stable for every step."""
        rate = self.derivative(own, centre, neighbour_centres, flock_velocity)
        pole_ps = self.rate_ps * (1 + len(neighbour_centres))
        gain_s = -math.expm1(-pole_ps * dt_s) / pole_ps
        return (centre[0] + gain_s * rate[0], centre[1] + gain_s * rate[1], centre[2] + gain_s * rate[2])
