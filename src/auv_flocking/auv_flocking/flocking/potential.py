"""
Flocking around a consensus centre, thesis Eqs. (5.12)-(5.43): attraction to the centre and the path,
repulsion from the others.

    leader    eta_dot = g [F_c + F_d + sum F_rep + sum F_obs] + eta_d_dot        (5.22), (5.40)
    follower  eta_dot = g [F_c (+ F_d) + sum F_rep + sum F_obs]                  (5.24)
    F_c = -k_c (eta - c),   F_d = -k_d (eta - eta_d)                             (5.13)-(5.17)

Deviations, each behind a parameter whose default is the thesis's form:

* printed (5.25), (5.43) and (6.31) give followers F_d although the text says that they do not know the path:
  ``followers``;
* k_c = k_d = 1, not the 10 of the extracted text: only 1 gives the printed distances;
* ``bandwidth_ratio`` g scales the whole position feedback. A law must not be faster than its information: at
  the update rates of acoustic modems g = 1 leads to collisions;
* ``leader_steers: centre`` makes the leader bring its estimate of the flock's centre to the path, F_d = -k_d
  (c - eta_d), as the text says ("the average centre of the group will follow the desired trajectory"),
  instead of itself;
* ``feedforward: flock`` gives every vehicle the flock's velocity w: the leader sets it, followers take the
  mean of their own and their neighbours' estimates, so that a blind flock does not lag behind its leader;
* ``correction_limit_mps`` limits the position feedback and the leader's steering, which is necessary for a
  hull of 190 kg.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_control.references import PathPoint
from auv_core.compiled import inlined
from auv_core.geometry import Vec3, added, limited
from auv_core.params import param
from auv_flocking.flocking import FlockingLaw, FlockVelocity, Member, View, learn
from auv_flocking.neighbours.estimates import Neighbours
from auv_flocking.separation import LearningLaw, SeparationLaw, obstacle_velocity_of

UNLIMITED_MPS = 1e9


@dataclass(frozen=True)
class Params:
    """The defaults are the thesis's law."""

    spacing_m: float = param("safety distance d between vehicles (m)", default=2.0, above=0.0)
    cohesion_gain_ps: float = param("gain k_c towards the flocking centre (1/s)", default=1.0, minimum=0.0)
    path_gain_ps: float = param("gain k_d towards the path (1/s)", default=1.0, minimum=0.0)
    bandwidth_ratio: float = param("factor g on the position feedback", default=1.0, above=0.0, maximum=1.0)
    followers: str = param(
        "whether followers are attracted to the path (printed) or not (blind)",
        default="printed",
        choices=("printed", "blind"),
    )
    leader_steers: str = param(
        "what a leader steers to the path", default="itself", choices=("itself", "centre")
    )
    feedforward: str = param(
        "feed-forward: the path's velocity for the leader only, or the flock's velocity for all",
        default="leader",
        choices=("leader", "flock"),
    )
    correction_limit_mps: float = param(
        "limit of the position feedback, and of a leader's steering (m/s)", default=UNLIMITED_MPS, above=0.0
    )

    @property
    def formation_spacing_m(self) -> float:
        """Largest distance kept between neighbours (m)."""
        return self.spacing_m

    @property
    def largest_correction_mps(self) -> float:
        """Largest speed that feedback and steering add to the velocity of the path (m/s; inf: no limit)."""
        return 2.0 * self.correction_limit_mps if self.correction_limit_mps < UNLIMITED_MPS else math.inf

    @property
    def uses_flock_velocity(self) -> bool:
        """Whether the law needs the flock's velocity from packets."""
        return self.feedforward == "flock"


@inlined
def attraction(own: Vec3, centre: Vec3, path: Vec3, cohesion_gain_ps: float, path_gain_ps: float) -> Vec3:
    """Return F_c + F_d (m/s; NED) of a vehicle at `own`, for its centre and its path point (m; NED)."""
    return (
        cohesion_gain_ps * (centre[0] - own[0]) + path_gain_ps * (path[0] - own[0]),
        cohesion_gain_ps * (centre[1] - own[1]) + path_gain_ps * (path[1] - own[1]),
        cohesion_gain_ps * (centre[2] - own[2]) + path_gain_ps * (path[2] - own[2]),
    )


@inlined
def asked(
    feedback: Vec3, ahead: Vec3, share: float, bandwidth_ratio: float, correction_limit_mps: float
) -> Vec3:
    """Return the velocity of the law (m/s; NED): its scaled and limited feedback, and a share of `ahead`."""
    slowed = (bandwidth_ratio * feedback[0], bandwidth_ratio * feedback[1], bandwidth_ratio * feedback[2])
    kept = limited(slowed, correction_limit_mps)
    return (kept[0] + share * ahead[0], kept[1] + share * ahead[1], kept[2] + share * ahead[2])


class Flocking(FlockingLaw):
    """
    The law of one vehicle.

    `path_gain_ps` is its gain towards the path, zero if it is not attracted to it; `feedforward_share` is
    the used share of the feed-forward velocity, 1 or 0.
    """

    def __init__(self, params: Params, separation: SeparationLaw, member: Member) -> None:
        self._params = params
        self._separation = separation
        self._from_obstacle = obstacle_velocity_of(separation)
        self._learning = separation if isinstance(separation, LearningLaw) else None
        self._is_leader = is_leader = member.is_leader
        steers_itself = params.leader_steers == "itself" if is_leader else params.followers == "printed"
        self.path_gain_ps = params.path_gain_ps if steers_itself else 0.0
        self.feedforward_share = 1.0 if is_leader or params.feedforward == "flock" else 0.0

    def hear(self, estimates: Neighbours, dt_s: float) -> None:
        """Do nothing: this law does not use the age of its information."""

    def flock_velocity(
        self,
        t_s: float,
        path: PathPoint,
        centre: Vec3,
        own: FlockVelocity,
        estimates: Neighbours,
    ) -> FlockVelocity:
        """
        Return this vehicle's estimate of the flock's velocity (m/s; NED).

        Parameters
        ----------
        t_s : float
            Scenario time (s); a leader stamps its estimate with it.
        path : PathPoint
            The reference; only a leader uses it.
        centre : (3,) tuple
            Own estimate of the flocking centre (m; NED).
        own : FlockVelocity
            Own latest estimate, which a follower averages with those of its neighbours.
        estimates : sequence of NeighbourEstimate
            The neighbours with their estimates of the flock's velocity.

        """
        p = self._params
        if not self._is_leader:
            heard = [own.velocity, *[estimate.flock_velocity for estimate in estimates]]
            count = len(heard)
            mean = (
                sum([v[0] for v in heard]) / count,
                sum([v[1] for v in heard]) / count,
                sum([v[2] for v in heard]) / count,
            )
            return FlockVelocity(mean, max([own.stamp_s, *[e.flock_stamp_s for e in estimates]]))
        if p.leader_steers == "itself":
            return FlockVelocity(path.velocity, t_s)
        error = attraction(centre, centre, path.position, 0.0, p.path_gain_ps)
        return FlockVelocity(added(path.velocity, limited(error, p.correction_limit_mps)), t_s)

    def velocity(self, view: View) -> Vec3:
        """Return the commanded velocity over ground (m/s; NED)."""
        p = self._params
        feedback = attraction(
            view.position, view.centre, view.path.position, p.cohesion_gain_ps, self.path_gain_ps
        )
        for other in view.neighbours:
            feedback = added(feedback, self._separation.velocity(view.position, other, p.spacing_m))
        for obstacle, safety_distance_m in view.obstacles:
            feedback = added(feedback, self._from_obstacle(view.position, obstacle, safety_distance_m))
        for each in view.sensed:
            push = self._from_obstacle(view.position, each.position, each.safety_distance_m)
            feedback = added(feedback, push)
        ahead = view.flock_velocity if p.feedforward == "flock" else view.path.velocity
        return asked(feedback, ahead, self.feedforward_share, p.bandwidth_ratio, p.correction_limit_mps)

    def adapt(self, view: View, dt_s: float) -> None:
        """
        Update a separation law with a state for one control period of `dt_s`; do nothing for others.

        The agent calls it once per control period, after `velocity` with the same view, and not while it
        holds station.
        """
        if self._learning is not None:
            learn(self._learning, view, self._params.spacing_m, dt_s)
