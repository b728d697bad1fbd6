"""The task of a vehicle in a flock: a velocity from the flocking law, a centre from consensus."""

from __future__ import annotations

import math
from collections.abc import Sequence

from auv_control.controllers import VelocityController, VelocityReference
from auv_control.references import PathPoint
from auv_core.compiled import fastest
from auv_core.geometry import Vec3, heading_from_quaternion
from auv_core.messages import Command, VehicleState
from auv_flocking.consensus import ConsensusFilter, ContinuousFilter, centres_within
from auv_flocking.flocking import NOTHING_HEARD, FlockingLaw, FlockVelocity, RecordedLaw, RosterLaw, View
from auv_flocking.neighbours.estimates import (
    Estimates,
    Neighbours,
    Positions,
    heading_nearest_leader_rad,
)
from auv_flocking.pings import NO_PING, Ping
from auv_flocking.trackers import Sensed

Obstacles = tuple[tuple[Vec3, float], ...]

_ZERO: Vec3 = (0.0, 0.0, 0.0)


class FlockTask:
    """
    Flocking law, consensus filter and the velocity controller under them.

    After a step: `centre` and `centre_rate` (own estimate of the flocking centre, m and m/s; NED),
    `flock_velocity` (m/s; NED, with its stamp), `reference` (the law's velocity, and the heading to hold),
    `law_state` (of a `RecordedLaw`) and `is_staying` (whether the vehicle stays where it is and does not go
    with the flock). `vouched_s` is that of a `RosterLaw`, inf for others.
    Only a leader (`is_leader`) uses the heading of the path.
    """

    def __init__(
        self,
        law: FlockingLaw,
        consensus: ConsensusFilter,
        controller: VelocityController,
        obstacles: Obstacles,
        period_s: float,
        *,
        is_leader: bool,
    ) -> None:
        self._law = law
        self._recorded = law if isinstance(law, RecordedLaw) else None
        self.vouched_s = law.vouched_s if isinstance(law, RosterLaw) else math.inf
        self._consensus = consensus
        self._continuous = consensus if isinstance(consensus, ContinuousFilter) else None
        self._controller = controller
        self._obstacles = obstacles
        self._period_s = period_s
        self._is_leader = is_leader
        self._heading_nearest_leader_rad = fastest(heading_nearest_leader_rad)
        self._heading_rad = math.nan
        self.centre: Vec3 = _ZERO
        self.centre_rate: Vec3 = _ZERO
        self.flock_velocity: FlockVelocity = NOTHING_HEARD
        self.reference = VelocityReference(_ZERO, 0.0)
        self.is_staying = False

    @property
    def law_state(self) -> tuple[float, ...]:
        """State of a law that has one to record, `()` for others."""
        return () if self._recorded is None else self._recorded.state

    def step(
        self,
        t_s: float,
        nav: VehicleState,
        path: PathPoint,
        neighbours: Neighbours,
        sensed: Sensed = (),
        ping: Ping = NO_PING,
        *,
        is_waiting: bool,
    ) -> Command:
        """Return the command of one control period; while `is_waiting` the vehicle holds station."""
        law, consensus, period_s = self._law, self._consensus, self._period_s
        position, estimates = nav.position, Estimates.of(neighbours)
        law.hear(estimates, period_s)
        self.centre = centre = consensus.centre(position, estimates)
        self.flock_velocity = law.flock_velocity(t_s, path, centre, self.flock_velocity, estimates)
        flock = self.flock_velocity.at(t_s)
        view = View(
            position, centre, flock, Positions(estimates), self._obstacles, path, estimates, sensed, ping
        )
        velocity = law.velocity(view)
        if not is_waiting:
            law.adapt(view, period_s)
        self.is_staying = is_waiting or law.is_staying
        heading_rad = self._facing_rad(path, nav, estimates)
        self.reference = VelocityReference(_ZERO if is_waiting else velocity, heading_rad)
        command = self._controller.step(nav, self.reference)
        self.centre_rate = consensus.advance(position, estimates, flock, period_s)
        return command

    def _facing_rad(self, path: PathPoint, nav: VehicleState, estimates: Estimates) -> float:
        """
        Return the heading to hold (rad): the path's for a leader, for others what packets say.

        A follower takes the heading of the neighbour nearest to a leader, from its newest packet. Before the
        first such packet it holds the heading that it had at its first step.
        """
        if self._is_leader:
            return path.heading_rad
        heard_rad = self._heading_nearest_leader_rad(estimates.rows)
        if not math.isnan(heard_rad):
            self._heading_rad = heard_rad
        elif math.isnan(self._heading_rad):
            self._heading_rad = heading_from_quaternion(nav.attitude)
        return self._heading_rad

    def shared(self) -> tuple[float, ...]:
        """Return the numbers that the consensus filter adds to a packet after this step."""
        return self._consensus.shared()

    def rates(
        self, path: PathPoint, position: Vec3, centre: Vec3, others: Sequence[tuple[Vec3, Vec3]]
    ) -> tuple[Vec3, Vec3]:
        """
        Return the velocity of the law and the rate of the estimate of the centre (m/s; NED).

        The law and the filter of a `step`, at one instant of continuous time: the caller keeps the estimate
        `centre` (m; NED), and `others` are the positions and the estimates of all others (m; NED).
        """
        flock = self.flock_velocity.velocity
        positions = tuple([place for place, _ in others])
        velocity = self._law.velocity(View(position, centre, flock, positions, self._obstacles, path))
        if self._continuous is None:
            raise TypeError("a consensus filter without a continuous form")
        heard = centres_within(self._continuous.reach_m, position, others)
        return velocity, self._continuous.derivative(position, centre, heard, flock)
