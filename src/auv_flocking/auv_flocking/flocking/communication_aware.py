"""
Flocking that is no faster than its information: the thesis's law on a real modem.

    u   = w + barrier( limited( g k_c (c - eta) + sum_j g_j F(eta - eta_j, d_j),  min(u_max, l / A) ) )
    w   = eta_d_dot + limited( g k_l (eta_d - c),  w_max )          leader; followers: the newest they heard
    g   = min(1, phi / A),        g_j = min(1, phi / A_j)
    d_j = d + min(k_s sigma_j, m),   sigma_j^2 = n_j . P_j n_j + (k_v a_j |v_j - w|)^2
    barrier:  n_j . (u - w) >= -1/2 min(alpha, 1 / a_j) (r_j - D - min(k_b sigma_j, m))     for every j

eta, eta_j: own position and the neighbour's as believed, r_j their distance, n_j the direction from the
neighbour; c: own estimate of the flock's centre; F: the separation law; P_j: covariance of the relative
position; v_j: the neighbour's velocity as believed; a_j: age of what is known of it, since its newest packet
or since the own sonar saw it; A_j: age of its newest packet, or what that has been of late if it is more,
and the hull's lag where the sonar sees it; A: mean of the packets' A_j over the neighbours.

1. A feedback of gain g on information of age A turns by g A (rad) at its crossover; phi bounds that, so the
   loop stays as well damped at 20 s as at 1 s.  The ages are measured, packet by packet, never configured:
   a slot length, a loss rate or a collision in the water need not be known.
2. A neighbour whose place is uncertain is kept at a greater distance: by its filter's covariance, which has
   both navigations in it, and by what its velocity in the flock could carry it since it was heard.
3. A neighbour that the sonar sees is as old as the contact, and so is repelled with a fast gain.  Gains go by
   what ages usually are: with the age of the moment the force would jump with every packet.
4. w carries the flock; all else is a correction in the frame that moves with it.  A leader brings the
   centre to the path (thesis: "the average centre of the group will follow the desired trajectory"); w goes
   from vehicle to vehicle with the leader's time stamp, so that the newest wins and who does not hear the
   leader still follows.
5. The barrier bounds the approach to every neighbour, each vehicle taking half, so that two that keep to it
   do not come closer than D plus margin whatever the sum of attractions asks (`auv_flocking.half_spaces`).

Deviation: thesis Eqs. (5.22)-(5.24) have g = g_j = 1 and d_j = d, a leader that steers itself, and followers
that are not told w.  With all information fresh, one leader and no margin this law is that law with u_max.
docs/safe_flocking.md measures what each part is worth.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from auv_control.references import PathPoint
from auv_core.geometry import Vec3, limited
from auv_core.params import param
from auv_flocking.flocking import FlockVelocity, View
from auv_flocking.flocking.potential import SeparationLaw
from auv_flocking.half_spaces import HalfSpace, into_half_spaces
from auv_flocking.neighbours import NeighbourEstimate

_NO_DIRECTION_M = 1e-9
_NO_AGE_S = 1e-3


@dataclass(frozen=True)
class Params:
    """The defaults are those of the safety study; the symbols are the module's."""

    spacing_m: float = param("distance d at which neighbours begin to repel (m)", default=2.0, above=0.0)
    cohesion_gain_ps: float = param("gain k_c towards the flocking centre (1/s)", default=1.0, minimum=0.0)
    path_gain_ps: float = param(
        "gain k_l with which a leader brings the centre to the path (1/s)", default=2.0, minimum=0.0
    )
    lag_budget_rad: float = param(
        "largest product phi of a gain and the age of what it works on (rad); 1e9: gains as they are",
        default=0.3,
        above=0.0,
    )
    age_memory_s: float = param(
        "time over which the age of the packets is averaged (s)", default=40.0, above=0.0
    )
    correction_limit_mps: float = param("largest correction u_max (m/s)", default=0.25, above=0.0)
    reach_m: float = param(
        "farthest l that a correction may carry within one age of information (m)", default=2.0, above=0.0
    )
    steering_limit_mps: float = param(
        "largest w_max that a leader adds to the path's velocity (m/s)", default=0.15, minimum=0.0
    )
    spacing_sigmas: float = param(
        "standard deviations k_s by which the spacing is widened", default=2.0, minimum=0.0
    )
    widening_limit_m: float = param("largest widening m (m)", default=3.0, minimum=0.0)
    closing_ratio: float = param(
        "share k_v of a neighbour's velocity in the flock that counts as uncertainty",
        default=0.3,
        minimum=0.0,
    )
    barrier: bool = param("whether the approach to neighbours and obstacles is bounded", default=True)
    barrier_distance_m: float = param("distance D that the barrier keeps (m)", default=1.3, minimum=0.0)
    barrier_rate_ps: float = param("fastest decay alpha of the distance left (1/s)", default=0.5, above=0.0)
    barrier_sigmas: float = param(
        "standard deviations k_b by which the barrier's distance is widened", default=1.0, minimum=0.0
    )
    response_s: float = param(
        "age of what is always known, such as obstacles: the hull's own lag (s)", default=1.0, above=0.0
    )
    relay: str = param(
        "which flock velocity a follower takes: the newest, or the mean of all it heard",
        default="newest",
        choices=("newest", "mean"),
    )

    def __post_init__(self) -> None:
        """Refuse a barrier outside the spacing: it would hold vehicles where the law pulls them together."""
        if self.barrier and self.barrier_distance_m >= self.spacing_m:
            raise ValueError(
                f"barrier_distance_m: {self.barrier_distance_m!r} is not allowed; "
                f"allowed: less than spacing_m = {self.spacing_m!r}"
            )

    @property
    def uses_flock_velocity(self) -> bool:
        """Always: the law works in the frame that moves with the flock."""
        return True


class Flocking:
    """The law of one vehicle; it remembers how old its packets have been, and nothing else."""

    def __init__(self, params: Params, separation: SeparationLaw, is_leader: bool) -> None:
        self._params = params
        self._separation = separation
        self._from_obstacle = getattr(separation, "obstacle_velocity", separation.velocity)
        self._learn = getattr(separation, "adapt", None)
        self._is_leader = is_leader
        self._running_s = 0.0
        self._usual_age_s: dict[int, float] = {}
        self.age_s = 0.0

    @property
    def bandwidth_ratio(self) -> float:
        """Factor g on cohesion and steering."""
        return self._matched(self.age_s)

    def hear(self, estimates: Sequence[NeighbourEstimate], dt_s: float) -> None:
        """
        Measure the age A of what is known (`age_s`), once per control period of `dt_s`.

        A neighbour counts with the age of its newest packet or with the average of the last `age_memory_s`,
        whichever is more; the average starts with the time that it took to hear the neighbour at all.
        """
        share = min(1.0, dt_s / self._params.age_memory_s)
        total_s = 0.0
        for estimate in estimates:
            age_s = estimate.age_s
            usual_s = self._usual_age_s.get(estimate.address, self._running_s)
            usual_s += share * (age_s - usual_s)
            self._usual_age_s[estimate.address] = usual_s
            total_s += max(age_s, usual_s)
        self._running_s += dt_s
        self.age_s = total_s / len(estimates) if estimates else self._running_s

    def flock_velocity(
        self,
        t_s: float,
        path: PathPoint,
        centre: Vec3,
        own: FlockVelocity,
        estimates: Sequence[NeighbourEstimate],
    ) -> FlockVelocity:
        """
        Return this vehicle's belief of the flock's velocity w (m/s; NED).

        Parameters
        ----------
        t_s : float
            Scenario time (s); a leader stamps its belief with it.
        path : PathPoint
            The reference; only a leader looks at it.
        centre : (3,) tuple
            Own estimate of the flocking centre (m; NED).
        own : FlockVelocity
            Own latest belief.
        estimates : sequence of NeighbourEstimate
            The neighbours with their beliefs.

        """
        if self._is_leader:
            return FlockVelocity(self._steered(path, centre), t_s)
        newest = own
        for estimate in estimates:
            if estimate.flock_stamp_s > newest.stamp_s:
                newest = FlockVelocity(estimate.flock_velocity, estimate.flock_stamp_s)
        if self._params.relay == "newest":
            return newest
        heard = [own.velocity, *[estimate.flock_velocity for estimate in estimates]]
        x, y, z = (sum([v[axis] for v in heard]) / len(heard) for axis in range(3))
        return FlockVelocity((x, y, z), newest.stamp_s)

    def _steered(self, path: PathPoint, centre: Vec3) -> Vec3:
        p, gain = self._params, self._params.path_gain_ps * self.bandwidth_ratio
        x, y, z = path.position
        steer = limited(
            (gain * (x - centre[0]), gain * (y - centre[1]), gain * (z - centre[2])), p.steering_limit_mps
        )
        return (path.velocity[0] + steer[0], path.velocity[1] + steer[1], path.velocity[2] + steer[2])

    def velocity(self, view: View) -> Vec3:
        """Return the velocity over ground that the vehicle asks of itself (m/s; NED)."""
        p, own, flock = self._params, view.position, view.flock_velocity
        gain = p.cohesion_gain_ps * self.bandwidth_ratio
        x, y, z = (gain * (c - e) for c, e in zip(view.centre, own, strict=True))
        limit_mps = min(p.correction_limit_mps, p.reach_m / max(self.age_s, _NO_AGE_S))
        half_spaces: list[HalfSpace] = []
        for estimate in view.estimates:
            other, age_s = estimate.position, min(estimate.age_s, estimate.sonar_age_s)
            normal, distance_m = _direction(own, other)
            sigma_m = self._sigma_m(estimate, normal, age_s, flock)
            spacing_m = p.spacing_m + min(p.spacing_sigmas * sigma_m, p.widening_limit_m)
            factor = self._matched(self._gain_age_s(estimate))
            dx, dy, dz = self._separation.velocity(own, other, spacing_m)
            x, y, z = x + factor * dx, y + factor * dy, z + factor * dz
            if p.barrier:
                rate_ps = 0.5 * min(p.barrier_rate_ps, 1.0 / max(age_s, _NO_AGE_S))
                keep_m = p.barrier_distance_m + min(p.barrier_sigmas * sigma_m, p.widening_limit_m)
                half_spaces.append((normal, min(-rate_ps * (distance_m - keep_m), limit_mps)))
        factor = self._matched(p.response_s)
        for obstacle, safety_distance_m in view.obstacles:
            dx, dy, dz = self._from_obstacle(own, obstacle, safety_distance_m)
            x, y, z = x + factor * dx, y + factor * dy, z + factor * dz
            if p.barrier:
                half_spaces.append(self._obstacle_bound(own, obstacle, safety_distance_m, flock))
        correction = limited((x, y, z), limit_mps)
        if half_spaces:
            correction = limited(into_half_spaces(correction, half_spaces), p.correction_limit_mps)
        return (flock[0] + correction[0], flock[1] + correction[1], flock[2] + correction[2])

    def adapt(self, view: View, dt_s: float) -> None:
        """Let a separation law with a memory learn from one control period of `dt_s`; see `potential`."""
        if self._learn is not None:
            distances_m = [math.dist(view.position, other) for other in view.neighbours]
            self._learn(distances_m, self._params.spacing_m, dt_s)

    def _gain_age_s(self, estimate: NeighbourEstimate) -> float:
        """
        Return the age that the repulsion from a neighbour goes by (s).

        It is what the age usually is, or is now if that is more: with the age of the moment the gain, and so
        the vehicle, would jump with every packet.  What the sonar sees is as old as the hull's own lag.
        """
        if estimate.sonar_age_s < estimate.age_s:
            return max(estimate.sonar_age_s, self._params.response_s)
        return max(estimate.age_s, self._usual_age_s.get(estimate.address, 0.0))

    def _matched(self, age_s: float) -> float:
        """Return the factor that brings a gain down to what information of this age allows."""
        return min(1.0, self._params.lag_budget_rad / max(age_s, _NO_AGE_S))

    def _sigma_m(self, estimate: NeighbourEstimate, normal: Vec3, age_s: float, flock: Vec3) -> float:
        """Return how uncertain the distance to a neighbour is, one standard deviation (m)."""
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = estimate.covariance[:3, :3].tolist()
        nx, ny, nz = normal
        variance_m2: float = (
            nx * nx * xx + ny * ny * yy + nz * nz * zz + 2.0 * (nx * ny * xy + nx * nz * xz + ny * nz * yz)
        )
        moved_m = self._params.closing_ratio * age_s * math.dist(estimate.velocity, flock)
        return math.sqrt(max(variance_m2, 0.0) + moved_m * moved_m)

    def _obstacle_bound(self, own: Vec3, obstacle: Vec3, safety_distance_m: float, flock: Vec3) -> HalfSpace:
        """Return the bound of an obstacle: it does not move with the flock, and all of the way is ours."""
        p = self._params
        normal, distance_m = _direction(own, obstacle)
        keep_m = p.barrier_distance_m * safety_distance_m / p.spacing_m
        flock_mps = normal[0] * flock[0] + normal[1] * flock[1] + normal[2] * flock[2]
        bound_mps = -p.barrier_rate_ps * (distance_m - keep_m) - flock_mps
        return normal, min(bound_mps, p.correction_limit_mps)


def _direction(own: Vec3, other: Vec3) -> tuple[Vec3, float]:
    """Return the unit vector from `other` to `own`, and the distance (m); up where there is no direction."""
    x, y, z = own[0] - other[0], own[1] - other[1], own[2] - other[2]
    distance_m = math.sqrt(x * x + y * y + z * z)
    if distance_m < _NO_DIRECTION_M:
        return (0.0, 0.0, -1.0), distance_m
    return (x / distance_m, y / distance_m, z / distance_m), distance_m
