"""
Proportional dynamic-average consensus, thesis Eqs. (5.10)-(5.11) and (6.4)-(6.5).

    c_i_dot = k [(eta_i - c_i) + sum_j a_ij (c_j - c_i)],       together  c_dot = k [-(L + I) c + eta]

For vehicles at rest c -> (L + I)^-1 eta: the mean of the estimates is exact, each estimate is biased towards
its own vehicle (on a complete graph of n by (eta_i - mean) / (n + 1)).  The proof (6.7)-(6.18) bounds the
error, V_dot <= -|e|^2 + |e| n rho; neither the proof nor the filter makes it vanish.

A received estimate is extrapolated to the current time with a rate. `carried_by: rate` adds c_dot to every
packet, which makes it longer. With data of age tau, a mode of the weights' eigenvalue a then has s + k (n - a
(1 + s tau) exp(-s tau)) = 0 on a complete graph. This is a neutral delay equation whose fast modes grow
without bound if k (n - 1) tau > 1, which is above 0.33 s for four vehicles and k = 1. `carried_by: flock`
uses the flock's velocity, which packets have anyway (zero without `follow_flock`); the filter is then a chain
of weighted means and stable with data of any age.

Deviation: `follow_flock` adds the flock's velocity to every c_i_dot, which removes the lag of 1 / k behind a
moving flock.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from auv_core.compiled import inlined
from auv_core.geometry import Vec3
from auv_core.params import param
from auv_flocking.codec import Field, steps_around_zero
from auv_flocking.consensus import ContinuousFilter, carried_centre, centres_within
from auv_flocking.neighbours.estimates import NeighbourEstimate, Neighbours


@dataclass(frozen=True)
class Params:
    """The defaults are the thesis's filter."""

    rate_ps: float = param("rate k of the filter (1/s)", default=1.0, above=0.0)
    reach_m: float | None = param(
        "only vehicles nearer than this are neighbours in the filter (m); null: all that are heard",
        default=None,
        above=0.0,
    )
    follow_flock: bool = param("whether to add the flock's velocity to the estimate's rate", default=False)
    carried_by: str = param(
        "rate for extrapolation of the estimate: its own, added to packets, or only the flock's velocity",
        default="rate",
        choices=("rate", "flock"),
    )

    @property
    def uses_flock_velocity(self) -> bool:
        """Whether the filter needs the flock's velocity from packets."""
        return self.follow_flock


_RATE_FIELDS = tuple(
    steps_around_zero(f"centre_rate_{axis}_mps", 0.005, 2**9) for axis in ("north", "east", "down")
)


@inlined
def towards(pull: Vec3, other: Vec3, centre: Vec3) -> Vec3:
    """Return `other` plus the terms that pull the estimate `centre` (m; NED)."""
    return (
        pull[0] + other[0] - centre[0],
        pull[1] + other[1] - centre[1],
        pull[2] + other[2] - centre[2],
    )


class Consensus(ContinuousFilter):
    """One vehicle's filter; in continuous time the caller keeps the estimate."""

    def __init__(self, params: Params, fleet_size: int) -> None:
        del fleet_size
        self.rate_ps = params.rate_ps
        self.reach_m = math.inf if params.reach_m is None else params.reach_m
        self._follow = 1.0 if params.follow_flock else 0.0
        self._states_own_rate = params.carried_by == "rate"
        self.shared_fields: tuple[Field, ...] = _RATE_FIELDS if self._states_own_rate else ()
        self._rate: Vec3 = (0.0, 0.0, 0.0)
        self._centre: Vec3 | None = None

    def centre(self, own: Vec3, heard: Neighbours) -> Vec3:
        """Return the estimate at this control period (m; NED); the first one is the own position."""
        del heard
        if self._centre is None:
            self._centre = own
        return self._centre

    def advance(self, own: Vec3, heard: Neighbours, flock_velocity: Vec3, dt_s: float) -> Vec3:
        """Update the estimate by `dt_s`; return the rate for its extrapolation (m/s; NED)."""
        centre = self.centre(own, heard)
        theirs = [(other.position, carried_centre(other, self._rate_of(other))) for other in heard]
        centres = centres_within(self.reach_m, own, theirs)
        rate = self.derivative(own, centre, centres, flock_velocity)
        self._centre = self._moved(centre, rate, len(centres), dt_s)
        self._rate = rate if self._states_own_rate else self._flock_rate(flock_velocity)
        return self._rate

    def _rate_of(self, other: NeighbourEstimate) -> Vec3:
        """Return the rate of a neighbour's estimate since its packet (m/s; NED)."""
        if self._states_own_rate:
            x, y, z = other.shared
            return (x, y, z)
        return self._flock_rate(other.flock_velocity)

    def _flock_rate(self, flock_velocity: Vec3) -> Vec3:
        f = self._follow
        return (f * flock_velocity[0], f * flock_velocity[1], f * flock_velocity[2])

    def shared(self) -> tuple[float, ...]:
        """Return the rate of the estimate (m/s; NED), or nothing if others use the flock's velocity."""
        return self._rate if self._states_own_rate else ()

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
        return self._moved(centre, rate, len(neighbour_centres), dt_s)

    def _moved(self, centre: Vec3, rate: Vec3, neighbours: int, dt_s: float) -> Vec3:
        """Return an estimate that moves at `rate` now (m/s; NED), `dt_s` later."""
        pole_ps = self.rate_ps * (1 + neighbours)
        gain_s = -math.expm1(-pole_ps * dt_s) / pole_ps
        return (centre[0] + gain_s * rate[0], centre[1] + gain_s * rate[1], centre[2] + gain_s * rate[2])
