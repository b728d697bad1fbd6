"""
Proportional-integral dynamic-average consensus: no steady-state error for inputs at rest.

Freeman, Yang & Lynch, "Stability and convergence properties of dynamic average consensus estimators", CDC
2006, with weights a_ij = 1/n for a fleet of n, L the Laplacian of the communication graph and eta the
positions:

    c_dot = g (eta - c) - k_p L c + k_i L^T q,      q_dot = -k_i L c

At rest L c = 0, so all estimates agree, and the sum over the vehicles is g (sum eta - sum c) = 0: they agree
on the mean. This holds on every connected balanced graph and for any initial q, so a lost packet or a restart
leaves no error. Every packet carries q (three numbers).

Received data are seconds old, which bounds the gains. If the neighbours' terms are delayed by tau, L becomes
l(s) = d - a exp(-s tau), d = (n - 1)/n the degree and a an eigenvalue of the weights, |a| <= d, and a mode
has

    s + g + k_p l + k_i^2 l^2 / s = 0.

For the mean, a = d: for Re s >= 0, |1 - exp(-s tau)| <= min(2, |s| tau), so the last term is at most 2 k_i^2
d^2 tau while the rest has a real part of at least g: it is stable if 2 k_i^2 d^2 tau < g (sufficient), which
`Params` requires at `oldest_s`. The other modes have a larger margin: tests count their unstable roots and
find none for gains at that limit, and none up to 24 s with the defaults. The mean of motions within the flock
is tracked at a rate of about g / (1 + k_p d tau), so more slowly with older data. `follow_flock` adds the
flock's velocity to every c_dot, so that the loop only has to track motions within the flock.

Own terms are integrated implicitly (backward Euler, constant neighbours), which is stable for every step and
has the same equilibria. Only differences of q count, and their mean may drift with losses and rounding: q is
sent and kept modulo 2048 m.

Deviation: the rate that others use for extrapolation is the flock's velocity (or zero) and not c_dot:
extrapolation over the seconds between packets would amplify a transient of one second.
"""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.geometry import Vec3
from auv_core.params import param
from auv_flocking.codec import Field
from auv_flocking.consensus import ConsensusFilter, carried_centre
from auv_flocking.neighbours.estimates import NeighbourEstimate, Neighbours

_HALF_RANGE_M = 1024.0
_RESOLUTION_M = 2.0**-5
_AXES = ("north", "east", "down")
_STILL: Vec3 = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Params:
    """With the defaults the filter settles with data up to `oldest_s` old."""

    input_rate_ps: float = param("rate g towards the own position (1/s)", default=0.5, above=0.0)
    agreement_rate_ps: float = param(
        "proportional rate k_p towards the neighbours (1/s)", default=0.2, minimum=0.0
    )
    integral_rate_ps: float = param("integral rate k_i (1/s)", default=0.17, above=0.0)
    oldest_s: float = param(
        "age of the neighbours' data up to which the gains must be stable (s)", default=8.0, minimum=0.0
    )
    follow_flock: bool = param("whether to add the flock's velocity to the estimate's rate", default=True)

    def __post_init__(self) -> None:
        most_ps = (0.5 * self.input_rate_ps / self.oldest_s) ** 0.5 if self.oldest_s > 0.0 else float("inf")
        if self.integral_rate_ps > most_ps:
            raise ValueError(
                f"integral_rate_ps: {self.integral_rate_ps!r} is not allowed; allowed: at most "
                f"{most_ps:.4g}, the square root of input_rate_ps / (2 oldest_s); above it old data may make "
                "the filter unstable"
            )

    @property
    def uses_flock_velocity(self) -> bool:
        """Whether the filter needs the flock's velocity from packets."""
        return self.follow_flock


def _wrapped(value: float) -> float:
    """Return `value` modulo the range, nearest to zero (m)."""
    return (value + _HALF_RANGE_M) % (2.0 * _HALF_RANGE_M) - _HALF_RANGE_M


class Consensus(ConsensusFilter):
    """One vehicle's filter; it starts at the own position."""

    shared_fields: tuple[Field, ...] = tuple(
        Field(f"integral_{axis}_m", -_HALF_RANGE_M, _HALF_RANGE_M, _RESOLUTION_M, wraps=True)
        for axis in _AXES
    )

    def __init__(self, params: Params, fleet_size: int) -> None:
        self._params = params
        self._weight = 1.0 / fleet_size
        self._centre: Vec3 | None = None
        self._integral: Vec3 = (0.0, 0.0, 0.0)

    def centre(self, own: Vec3, heard: Neighbours) -> Vec3:
        """Return the estimate (m; NED)."""
        if self._centre is None:
            self._centre = own
        return self._centre

    def advance(self, own: Vec3, heard: Neighbours, flock_velocity: Vec3, dt_s: float) -> Vec3:
        """Update the estimate; return the flock's velocity (m/s; NED), or zero if it is not used."""
        centre = self.centre(own, heard)
        rate = flock_velocity if self._params.follow_flock else _STILL
        centres = [self._carried(other) for other in heard]
        moved = [self._axis(axis, own[axis], centre[axis], heard, centres, dt_s) for axis in range(3)]
        (x, qx), (y, qy), (z, qz) = moved
        self._centre = (x + rate[0] * dt_s, y + rate[1] * dt_s, z + rate[2] * dt_s)
        self._integral = (qx, qy, qz)
        return rate

    def _carried(self, other: NeighbourEstimate) -> Vec3:
        return carried_centre(other, other.flock_velocity if self._params.follow_flock else _STILL)

    def _axis(
        self, axis: int, own: float, centre: float, heard: Neighbours, centres: list[Vec3], dt_s: float
    ) -> tuple[float, float]:
        """Return estimate and integral of one axis after a backward Euler step in their increments."""
        p, integral = self._params, self._integral[axis]
        ahead = lead = 0.0
        for other, theirs in zip(heard, centres, strict=True):
            ahead += theirs[axis] - centre
            lead += _wrapped(other.shared[axis] - integral)
        ahead *= self._weight
        lead *= self._weight
        degree = self._weight * len(heard)
        cross = dt_s * p.integral_rate_ps * degree
        own_rate_ps = p.input_rate_ps + p.agreement_rate_ps * degree
        pull = dt_s * (
            p.input_rate_ps * (own - centre) + p.agreement_rate_ps * ahead - p.integral_rate_ps * lead
        )
        push = dt_s * p.integral_rate_ps * ahead
        step = (pull + cross * push) / (1.0 + dt_s * own_rate_ps + cross * cross)
        return centre + step, _wrapped(integral + push - cross * step)

    def shared(self) -> tuple[float, ...]:
        """Return the integral q of the own filter (m, modulo 2048 m; NED)."""
        return self._integral
