"""
Flocking that is no faster than its information: the thesis's law for a real modem.

    u   = w + barrier( layer( limited( g_c k_c (c - eta) + sum_j g_j F(eta - eta_j, d_j), min(u_max, l/A) )))
    w   = eta_d_dot + limited( g k_l (eta_d - c),  min(w_max, s / A) )   leader; followers: the newest heard
    g   = min(1, phi / A),        g_j = min(1, phi / A_j),        g_c = g within R of the centre, more outside
    d_j = d + min(k_s sigma_j + k_n q_j, m),   sigma_j^2 = n_j . P_j n_j + (k_v a_j |v_j - w|)^2
    barrier:  n_j . (u - w) >= max(-1/2 h_j, n_j . (v_j - w) - h_j)     for every j
              h_j = min(alpha, 1 / a_j) (r_j - D - min(k_b sigma_j, m))

eta, eta_j: own position and the neighbour's estimated position, r_j their distance, n_j the direction from
the neighbour; c: own estimate of the flock's centre; F: the separation law; P_j: covariance of the relative
position; v_j: the neighbour's estimated velocity; a_j: age of the estimate, since the newest packet or sonar
contact; A_j: age of the newest packet or its recent average, whichever is larger, and the hull's lag if the
sonar sees the neighbour; A: mean of the packets' A_j over the neighbours.

1. A feedback of gain g on information of age A has a phase lag of g A (rad) at its crossover frequency. phi
   bounds this lag, so the loop is as well damped at 20 s as at 1 s. The ages are measured, packet by packet,
   and never configured: slot length, loss rate and collisions need not be known. The way to the centre from
   outside of R has a budget of its own: the centre of all stays where it is while they gather.
2. A neighbour with an uncertain position is kept at a larger distance. The uncertainty is its filter's
   covariance, which includes both navigations, and the distance that its velocity in the flock could have
   covered since the last packet. The part q_j due to navigation, the smaller of (n_j . P_j n_j)^1/2 and the
   deviation that the neighbour states, counts more: it lasts for minutes, the rest until the next packet.
3. For a neighbour that the sonar sees, the age is that of the contact, so it is repelled with a high gain.
   Gains use average ages: with the current age the force would jump with every packet.
4. w moves the flock; all other terms are a correction in the frame that moves with w. A leader brings the
   centre to the path (thesis: "the average centre of the group will follow the desired trajectory"). Vehicles
   pass w on with the leader's time stamp, so that the newest one is used, and vehicles that do not hear the
   leader still follow. It has its rate of turn with it, so that one that is a minute old still points along
   the path. A leader steers slowly: the flock spreads by the change of w times the age.
5. The barrier bounds the approach to every neighbour (`auv_flocking.flocking._half_spaces`). Each vehicle
   takes half, so that two that obey it do not come closer than D plus margin, whatever attracts them. The
   neighbour may not know of this vehicle: so it yields to one that comes nearer by more than its half.
6. Each vehicle keeps a depth of its own (`auv_flocking.flocking._layers`), always or while some other vehicle
   is silent: no bound on an approach helps against a neighbour that may be anywhere.

Deviation: thesis Eqs. (5.22)-(5.24) have g = g_j = 1 and d_j = d, a leader that steers itself, and followers
that do not know w. With fresh information, one leader and no margin this law equals that law with u_max.
docs/explanation/safe_flocking.md measures what each part is worth.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from auv_control.references import PathPoint
from auv_core.compiled import fastest, specialised
from auv_core.geometry import Vec3, limited
from auv_core.params import param
from auv_flocking.flocking import FlockingLaw, FlockVelocity, Member, View, learn
from auv_flocking.flocking._avoidance import Obstacles, known_rows, obstacle_spacing_m, sensed_rows
from auv_flocking.flocking._correction import (
    Gains,
    correction,
    matched,
    newer_stamp,
    outlook,
    remember_ages,
)
from auv_flocking.flocking._layers import LayerKeeper, layers_height_m
from auv_flocking.neighbours.estimates import (
    FLOCK_STAMP,
    FLOCK_TURN_RATE,
    FLOCK_VELOCITY,
    Estimates,
    Neighbours,
)
from auv_flocking.separation import CentralLaw, LearningLaw, SeparationLaw, obstacle_velocity_of
from auv_flocking.trackers import Sensed

Matrix = NDArray[np.float64]
_ADDRESSES = 256
_NO_PUSHES, _NO_NUMBERS = np.empty((0, 3)), np.empty(0)


@dataclass(frozen=True)
class Params:
    """The defaults are those of the safety study; the module explains the symbols."""

    spacing_m: float = param("distance d at which neighbours begin to repel (m)", default=2.0, above=0.0)
    cohesion_gain_ps: float = param("gain k_c towards the flocking centre (1/s)", default=1.0, minimum=0.0)
    gathering_m: float = param(
        "distance R from the centre outside of which a vehicle gathers (m)", default=4.0, above=0.0
    )
    gathering_budget_rad: float = param(
        "largest product of gain and age on the way to the centre outside of R (rad)", default=0.6, above=0.0
    )
    path_gain_ps: float = param(
        "gain k_l with which a leader brings the centre to the path (1/s)", default=2.0, minimum=0.0
    )
    lag_budget_rad: float = param(
        "largest product phi of a gain and the age of its information (rad); 1e9: no reduction of gains",
        default=0.3,
        above=0.0,
    )
    age_memory_s: float = param(
        "time over which the age of the packets is averaged (s)", default=40.0, above=0.0
    )
    correction_limit_mps: float = param("largest correction u_max (m/s)", default=0.25, above=0.0)
    reach_m: float = param(
        "largest distance l that a correction may cover within one age of information (m)",
        default=6.0,
        above=0.0,
    )
    steering_limit_mps: float = param(
        "largest speed w_max that a leader adds to the path's velocity (m/s)", default=0.15, minimum=0.0
    )
    steering_reach_m: float = param(
        "largest distance s that this speed may cover within one age of information (m)",
        default=1.5,
        above=0.0,
    )
    spacing_sigmas: float = param(
        "standard deviations k_s by which the spacing is widened", default=2.0, minimum=0.0
    )
    navigation_sigmas: float = param(
        "further standard deviations k_n for the part due to navigation", default=1.5, minimum=0.0
    )
    widening_limit_m: float = param("largest widening m (m)", default=3.0, minimum=0.0)
    closing_ratio: float = param(
        "fraction k_v of a neighbour's velocity in the flock that counts as uncertainty",
        default=0.3,
        minimum=0.0,
    )
    barrier: bool = param("whether the approach to neighbours and obstacles is bounded", default=True)
    barrier_distance_m: float = param("distance D that the barrier keeps (m)", default=1.3, minimum=0.0)
    barrier_rate_ps: float = param(
        "fastest decay alpha of the remaining distance (1/s)", default=0.5, above=0.0
    )
    barrier_sigmas: float = param(
        "standard deviations k_b by which the barrier's distance is widened", default=1.0, minimum=0.0
    )
    response_s: float = param(
        "age of information that is always known, such as obstacles: the hull's own lag (s)",
        default=1.0,
        above=0.0,
    )
    layer_depth_m: float | None = param(
        "depth z_m around which vehicles without news have layers (m); null: no layers", default=None
    )
    layer_m: float = param("largest distance of neighbouring layers (m)", default=1.5, above=0.0)
    layer_span_m: float = param("largest distance of all layers (m)", default=6.0, above=0.0)
    settling_s: float = param(
        "time during which one that has not heard all moves vertically (s)", default=0.0, minimum=0.0
    )
    silent_s: float = param(
        "age of news from which a vehicle takes its layer (s); 0: always", default=0.0, minimum=0.0
    )
    relay: str = param(
        "flock velocity that a follower uses: the newest, or the mean of all received",
        default="newest",
        choices=("newest", "mean"),
    )

    def __post_init__(self) -> None:
        """Refuse a barrier outside the spacing, where the law pulls vehicles together, and layers in air."""
        if self.barrier and self.barrier_distance_m >= self.spacing_m:
            raise ValueError(
                f"barrier_distance_m: {self.barrier_distance_m!r} is not allowed; "
                f"allowed: less than spacing_m = {self.spacing_m!r}"
            )
        if self.layer_depth_m is not None and self.layer_depth_m <= 0.5 * self.layer_span_m:
            raise ValueError(
                f"layer_depth_m: {self.layer_depth_m!r} is not allowed; allowed: more than half of "
                f"layer_span_m = {self.layer_span_m!r}, or null: the highest layer must be under water"
            )

    @property
    def formation_spacing_m(self) -> float:
        """Largest distance kept between neighbours, the widest spacing (m)."""
        return self.spacing_m + self.widening_limit_m

    def height_m(self, fleet_size: int) -> float:
        """Return the distance of the highest and the lowest layer (m)."""
        return layers_height_m(self, fleet_size)

    @property
    def largest_correction_mps(self) -> float:
        """Largest speed that the law adds to the velocity of the path (m/s)."""
        return self.correction_limit_mps + self.steering_limit_mps

    @property
    def uses_flock_velocity(self) -> bool:
        """Always: the law works in the frame that moves with the flock."""
        return True


class Flocking(FlockingLaw):
    """The law of one vehicle. Its state is what it knows of the ages of its packets, and of its layer."""

    def __init__(self, params: Params, separation: SeparationLaw, member: Member) -> None:
        self._params = params
        self._separation = separation
        self._from_obstacle = obstacle_velocity_of(separation)
        self._learning = separation if isinstance(separation, LearningLaw) else None
        self._is_leader = member.is_leader
        self._member = member
        self._layer = LayerKeeper(params, member)
        self._silent_s = -1.0
        self._gains = Gains(*(float(getattr(params, name)) for name in Gains._fields))
        self._gain_numbers = (*self._gains,)
        self._is_central = isinstance(separation, CentralLaw)
        self._correction: Callable[..., Vec3] = correction
        self._numbers = _NO_NUMBERS, _NO_NUMBERS
        if isinstance(separation, CentralLaw):
            self._correction = _correction(separation)
            self._numbers = separation.numbers, separation.obstacle_numbers
        self._obstacles: tuple[Obstacles, Matrix] = ((), known_rows(()))
        self._running_s = 0.0
        self._remember, self._newer_stamp = fastest(remember_ages), fastest(newer_stamp)
        self._usual_age_s = np.full(_ADDRESSES, -1.0)
        self.age_s = 0.0

    @property
    def bandwidth_ratio(self) -> float:
        """Factor g on cohesion and steering."""
        return matched(self._params.lag_budget_rad, self.age_s)

    def hear(self, estimates: Neighbours, dt_s: float) -> None:
        """
        Measure the age A of the information (`age_s`), once per control period of `dt_s`.

        A neighbour counts with the age of its newest packet or the average of the last `age_memory_s`,
        whichever is larger. The average starts with the time until its first packet. Alone: `response_s`.
        """
        share = min(1.0, dt_s / self._params.age_memory_s)
        known = Estimates.of(estimates)
        total_s, oldest_s = self._remember(known.rows, known.who, self._usual_age_s, self._running_s, share)
        self._running_s += dt_s
        self._silent_s = (
            oldest_s if len(known) >= self._member.fleet_size - 1 else max(oldest_s, self._running_s)
        )
        unheard_s = self._running_s if self._member.fleet_size > 1 else self._params.response_s
        self.age_s = total_s / len(known) if len(known) else unheard_s

    def flock_velocity(
        self,
        t_s: float,
        path: PathPoint,
        centre: Vec3,
        own: FlockVelocity,
        estimates: Neighbours,
    ) -> FlockVelocity:
        """
        Return this vehicle's estimate of the flock's velocity w (m/s; NED).

        Parameters
        ----------
        t_s : float
            Scenario time (s); a leader stamps its estimate with it.
        path : PathPoint
            The reference; only a leader uses it.
        centre : (3,) tuple
            Own estimate of the flocking centre (m; NED).
        own : FlockVelocity
            Own latest estimate.
        estimates : sequence of NeighbourEstimate
            The neighbours with their estimates of the flock's velocity.

        """
        if self._is_leader:
            return FlockVelocity(self._steered(path, centre), t_s, path.turn_rate_radps)
        rows, newest = Estimates.of(estimates).rows, own
        index = self._newer_stamp(rows, own.stamp_s)
        if index >= 0:
            row = rows[index]
            x, y, z = row[FLOCK_VELOCITY:FLOCK_STAMP].tolist()
            newest = FlockVelocity((x, y, z), float(row[FLOCK_STAMP]), float(row[FLOCK_TURN_RATE]))
        if self._params.relay == "newest":
            return newest
        heard = [own.velocity, *rows[:, FLOCK_VELOCITY:FLOCK_STAMP].tolist()]
        x, y, z = (sum([v[axis] for v in heard]) / len(heard) for axis in range(3))
        return newest._replace(velocity=(x, y, z))

    def _steered(self, path: PathPoint, centre: Vec3) -> Vec3:
        p, gain = self._params, self._params.path_gain_ps * self.bandwidth_ratio
        x, y, z = path.position
        steer = limited(
            (gain * (x - centre[0]), gain * (y - centre[1]), gain * (z - centre[2])),
            min(p.steering_limit_mps, p.steering_reach_m / max(self.age_s, p.response_s)),
        )
        return (path.velocity[0] + steer[0], path.velocity[1] + steer[1], path.velocity[2] + steer[2])

    def velocity(self, view: View) -> Vec3:
        """Return the commanded velocity over ground (m/s; NED)."""
        flock, estimates = view.flock_velocity, Estimates.of(view.estimates)
        layer = self._layer.layering(view.position[2], len(estimates), self._silent_s, self._running_s)
        x, y, z = self._correction(
            view.position,
            view.centre,
            flock,
            (estimates.rows, estimates.who, self._usual_age_s, self._as_rows(view.obstacles, view.sensed)),
            self.age_s,
            (self._gain_numbers, (*layer,)),
            self._numbers,
            _NO_PUSHES if self._is_central else self._pushes(view, estimates),
        )
        goes = layer.may_leave
        return (goes * flock[0] + x, goes * flock[1] + y, goes * flock[2] + z)

    def adapt(self, view: View, dt_s: float) -> None:
        """
        Remember that the vehicle has been in its layer; update a separation law with a state for one control
        period of `dt_s`, see `potential`.
        """
        layer = self._layer.layering(view.position[2], len(view.estimates), self._silent_s, self._running_s)
        self._layer.note(layer)
        self.is_staying = layer.may_leave == 0.0
        if self._learning is not None:
            learn(self._learning, view, self._params.spacing_m, dt_s)

    def _pushes(self, view: View, estimates: Estimates) -> Matrix:
        """Return the velocities from neighbours and obstacles for a separation law without `strength`."""
        own, flock, usual_s = view.position, view.flock_velocity, self._usual_age_s[estimates.who]
        spacings_m = [
            outlook(row, usual, own, flock, self._gains).spacing_m
            for row, usual in zip(estimates.rows, usual_s, strict=True)
        ]
        pushes = [
            self._separation.velocity(own, other, spacing_m)
            for other, spacing_m in zip(estimates.positions(), spacings_m, strict=True)
        ]
        pushes += [
            self._from_obstacle(own, obstacle, safety_distance_m)
            for obstacle, safety_distance_m in view.obstacles
        ]
        pushes += [
            self._from_obstacle(own, each.position, obstacle_spacing_m(row, self._gains))
            for each, row in zip(view.sensed, sensed_rows(view.sensed), strict=True)
        ]
        return np.array(pushes).reshape(-1, 3)

    def _as_rows(self, known: Obstacles, sensed: Sensed) -> Matrix:
        if self._obstacles[0] is not known:
            self._obstacles = known, known_rows(known)
        return np.concatenate((self._obstacles[1], sensed_rows(sensed))) if sensed else self._obstacles[1]


def _correction(law: CentralLaw) -> Callable[..., Vec3]:
    """Return the fastest correction with a separation law that acts along a line."""
    strengths = {"strength": law.strength, "obstacle_strength": law.obstacle_strength}
    return fastest(specialised(correction, **strengths))
