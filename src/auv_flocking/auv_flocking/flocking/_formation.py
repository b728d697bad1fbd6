"""
A formation with slots: what the laws `displacement` and `bearing` have in common.

The law gives a target; this gives the slots, the frame, the flock's velocity, the gain by age, and the
barrier. The symbols and reasons are in `displacement`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from auv_control.formations.frame import Course, Offset, world_offset
from auv_control.formations.shapes import NO_SHAPE, SHAPES, Slots, shape_slots
from auv_control.references import PathPoint
from auv_core.compiled import fastest
from auv_core.geometry import Vec3, added, distance, limited
from auv_core.params import param, same
from auv_flocking.flocking import FlockingLaw, FlockVelocity, Member, View, communication_aware
from auv_flocking.flocking._avoidance import known_rows, sensed_rows
from auv_flocking.flocking._barrier import held_apart
from auv_flocking.flocking._correction import Gains, matched, newer_stamp
from auv_flocking.flocking._roster import Roster
from auv_flocking.neighbours.estimates import (
    FLOCK_STAMP,
    FLOCK_TURN_RATE,
    FLOCK_VELOCITY,
    Estimates,
    Neighbours,
)
from auv_flocking.separation import SeparationLaw

_NOTICE_EVERY_S = 1.0
_STANDS_MPS = 1e-3
VOUCHED_RATIO = 0.5
"""Share of the time-out up to which a packet of another vehicle is told as news."""
_Aware = communication_aware.Params


@dataclass(frozen=True)
class FormationParams:
    """What every formation with slots has; `displacement` explains the symbols."""

    shape: str = param("shape of the formation", default="column", choices=SHAPES)
    spacing_m: float = param("distance d of neighbouring slots (m)", default=4.0, above=0.0)
    half_angle_deg: float = param(
        "angle between the course and each line of a wedge (degrees)",
        default=45.0,
        minimum=30.0,
        maximum=150.0,
    )
    offsets_m: tuple[float, ...] = param(
        "own offsets instead of a shape, three numbers for each address: forward, right, down (m)", default=()
    )
    next_shape: str = param(
        "shape to switch to; none: the first one is kept", default=NO_SHAPE, choices=(*SHAPES, NO_SHAPE)
    )
    switch_at_s: float = param("scenario time of the switch (s)", default=0.0, minimum=0.0)
    move_s: float = param("time T_s of a move to another slot (s)", default=60.0, above=0.0)
    lost_after_s: float = param(
        "age of the newest news from which a vehicle counts as lost (s)", default=60.0, above=0.0
    )
    gain_ps: float = param("gain k towards the desired position (1/s)", default=0.3, above=0.0)
    lag_budget_rad: float = same(_Aware, "lag_budget_rad")
    correction_limit_mps: float = param("largest correction u_max (m/s)", default=0.4, above=0.0)
    barrier_distance_m: float = same(_Aware, "barrier_distance_m")
    barrier_rate_ps: float = same(_Aware, "barrier_rate_ps")
    barrier_sigmas: float = same(_Aware, "barrier_sigmas")
    widening_limit_m: float = same(_Aware, "widening_limit_m", default=1.0)
    closing_ratio: float = same(_Aware, "closing_ratio")
    response_s: float = same(_Aware, "response_s")
    wreck_distance_m: float = param(
        "distance within which a vehicle steps aside for a lost one (m); it keeps 0.65 of it",
        default=3.0,
        above=0.0,
    )

    def __post_init__(self) -> None:
        """Refuse incomplete offsets, and a barrier wider than the formation."""
        if len(self.offsets_m) % 3:
            raise ValueError(
                f"offsets_m: {len(self.offsets_m)} numbers are not allowed; allowed: three for each address"
            )
        if self.barrier_distance_m >= self.spacing_m / math.sqrt(2.0):
            raise ValueError(
                f"barrier_distance_m: {self.barrier_distance_m!r} is not allowed; allowed: less than "
                f"spacing_m / sqrt(2) = {self.spacing_m / math.sqrt(2.0):.4g}, which moves keep"
            )

    @property
    def shares(self) -> dict[str, float]:
        """The share of each type of reference; here the leader's."""
        return {"leader": 1.0}

    @property
    def formation_spacing_m(self) -> float:
        """Distance of neighbouring slots (m)."""
        return self.spacing_m

    @property
    def largest_correction_mps(self) -> float:
        """Largest speed that the law adds to the velocity of the path (m/s)."""
        return self.correction_limit_mps

    @property
    def uses_flock_velocity(self) -> bool:
        """Always: the formation moves with the leader's velocity."""
        return True

    def extent_m(self, fleet_size: int) -> float:
        """Return the largest distance of two slots (m)."""
        shapes = [shape for shape in (self.shape, self.next_shape) if shape != NO_SHAPE]
        return max(
            distance(one, other)
            for shape in shapes
            for one in self.slots(shape, fleet_size)
            for other in self.slots(shape, fleet_size)
        )

    def height_m(self, fleet_size: int) -> float:
        """Return the largest difference in depth of two slots (m)."""
        depths_m = [slot[2] for slot in self.slots(self.shape, fleet_size)]
        return max(depths_m) - min(depths_m)

    def slots(self, shape: str, count: int) -> Slots:
        """Return the offsets of a shape, or the own ones, for a number of vehicles (m)."""
        if self.offsets_m and shape == self.shape:
            x = self.offsets_m
            if len(x) < 3 * count:
                raise ValueError(
                    f"offsets_m: those of {len(x) // 3} vehicles are not allowed; allowed: one for each of "
                    f"the {count}"
                )
            return tuple((x[3 * i], x[3 * i + 1], x[3 * i + 2]) for i in range(count))
        return shape_slots(shape, count, self.spacing_m, math.radians(self.half_angle_deg))

    def next_slots(self, count: int) -> Slots:
        """Return the offsets of the shape to switch to (m)."""
        return self.slots(self.next_shape, count)


class FormationLaw(FlockingLaw):
    """The law of one vehicle; its state is what it knows of the fleet, and the slots that follow from it."""

    def __init__(self, params: FormationParams, separation: SeparationLaw, member: Member) -> None:
        del separation  # the barrier keeps distances
        self._params = params
        self._member = member
        self.roster = roster_of(params, member)
        self._is_switched = params.next_shape == NO_SHAPE
        self._t_s, self._noticed_s = -math.inf, -math.inf
        self._turn_rate_radps = 0.0
        self._chi_rad = 0.0
        self._gains: tuple[float, ...] = (*_gains(params),)
        self._held_apart, self._newer_stamp = fastest(held_apart), fastest(newer_stamp)

    @property
    def state(self) -> tuple[float, ...]:
        """The slots of all vehicles, as this one holds them; see `Roster.state`."""
        return self.roster.state

    @property
    def vouched_s(self) -> float:
        """Half of the time-out: older packets do not help those that hear of them."""
        return VOUCHED_RATIO * self._params.lost_after_s

    @property
    def leads(self) -> bool:
        """Whether this vehicle is the leader."""
        return self.roster.order.leader == self._member.address

    def hear(self, estimates: Neighbours, dt_s: float) -> None:
        """Notice losses, once a second, and switch the shape when it is time."""
        self._t_s = now_s = 0.0 if math.isinf(self._t_s) else self._t_s + dt_s
        p = self._params
        if not self._is_switched and now_s >= p.switch_at_s:
            self._is_switched = True
            self.roster.switch(p.next_slots, p.switch_at_s)
        if now_s >= self._noticed_s + _NOTICE_EVERY_S:
            self._noticed_s = now_s
            self.roster.notice(now_s, Estimates.of(estimates))

    def flock_velocity(
        self, t_s: float, path: PathPoint, centre: Vec3, own: FlockVelocity, estimates: Neighbours
    ) -> FlockVelocity:
        """
        Return this vehicle's estimate of the flock's velocity (m/s; NED).

        A leader that knows the path gives the path's, one that does not goes on with the last. Others have
        the newest that they heard.
        """
        self._t_s = t_s
        if self._member.is_leader:
            newest = FlockVelocity(path.velocity, t_s, path.turn_rate_radps)
        elif self.leads and own.stamp_s > -math.inf:
            newest = FlockVelocity(own.at(t_s), t_s, own.turn_rate_radps)
        else:
            newest = self._newest(own, Estimates.of(estimates))
        self._turn_rate_radps = newest.turn_rate_radps
        return newest

    def _newest(self, own: FlockVelocity, estimates: Estimates) -> FlockVelocity:
        index = self._newer_stamp(estimates.rows, own.stamp_s)
        if index < 0:
            return own
        row = estimates.rows[index]
        x, y, z = row[FLOCK_VELOCITY:FLOCK_STAMP].tolist()
        return FlockVelocity((x, y, z), float(row[FLOCK_STAMP]), float(row[FLOCK_TURN_RATE]))

    def velocity(self, view: View) -> Vec3:
        """Return the commanded velocity over ground (m/s; NED)."""
        p, flock, estimates = self._params, view.flock_velocity, Estimates.of(view.estimates)
        course = self._course(flock)
        own = self.offset(self._member.address, course)
        wanted, age_s = self.target(view, estimates, own, course)
        asked = own.velocity
        if wanted is not None:
            gain_ps = p.gain_ps * matched(p.lag_budget_rad / p.gain_ps, age_s)
            error = (wanted[0] - view.position[0], wanted[1] - view.position[1], wanted[2] - view.position[2])
            step = limited(
                (gain_ps * error[0], gain_ps * error[1], gain_ps * error[2]), p.correction_limit_mps
            )
            asked = limited(added(asked, step), p.correction_limit_mps)
        wrecks = self.roster.wrecks
        for wreck in wrecks:
            asked = added(asked, self._aside(view.position, wreck, flock))
        known = (*view.obstacles, *((wreck, p.wreck_distance_m) for wreck in wrecks))
        obstacles = np.concatenate((known_rows(known), sensed_rows(view.sensed)))
        live = np.isin(estimates.who, self.roster.live)
        return added(
            flock, self._held_apart(asked, view.position, flock, estimates.rows[live], obstacles, self._gains)
        )

    def _aside(self, own: Vec3, wreck: Vec3, flock: Vec3) -> Vec3:
        """Return the velocity to the right past a lost vehicle ahead (m/s; NED)."""
        north_m, east_m = wreck[0] - own[0], wreck[1] - own[1]
        range_m, speed_mps = distance(own, wreck), math.hypot(flock[0], flock[1])
        reach_m = self._params.wreck_distance_m
        is_behind = north_m * flock[0] + east_m * flock[1] <= 0.0
        if is_behind or range_m >= 2.0 * reach_m or speed_mps < _STANDS_MPS:
            return (0.0, 0.0, 0.0)
        step_mps = self._params.correction_limit_mps * min(1.0, 2.0 - range_m / reach_m)
        return (-step_mps * flock[1] / speed_mps, step_mps * flock[0] / speed_mps, 0.0)

    def target(
        self, view: View, estimates: Estimates, own: Offset, course: Course
    ) -> tuple[Vec3 | None, float]:
        """
        Return the desired position (m; NED), and the age of the information behind it (s).

        There is none for a leader that does not know the path, and for a vehicle that knows none of those by
        which it steers.
        """
        raise NotImplementedError

    def offset(self, address: int, course: Course) -> Offset:
        """Return the world offset of a vehicle now (m, m/s, m/s^2; NED)."""
        return world_offset(self.roster.offset(address, self._t_s), course)

    def path_target(self, view: View, own: Offset) -> Vec3 | None:
        """Return where a leader wants to be (m; NED), None for one that does not know the path."""
        return added(view.path.position, own.position) if self._member.is_leader else None

    def _course(self, flock: Vec3) -> Course:
        """Return the course of the flock; one that stands keeps its last."""
        if math.hypot(flock[0], flock[1]) > _STANDS_MPS:
            self._chi_rad = math.atan2(flock[1], flock[0])
        return Course(self._chi_rad, self._turn_rate_radps)

    def adapt(self, view: View, dt_s: float) -> None:
        """Do nothing: this law has no separation law that adapts."""


def roster_of(params: FormationParams, member: Member) -> Roster:
    """Return the order of a fleet at the start, as one vehicle keeps it."""
    slots_of = partial(params.slots, params.shape)
    return Roster(member, params.shares, slots_of, params.lost_after_s, params.move_s)


def _gains(p: FormationParams) -> Gains:
    """Return the parameters of the barrier; those of the rest of `communication_aware` do not count."""
    numbers = {name: float(getattr(p, name, 0.0)) for name in Gains._fields}
    # An obstacle keeps the share of its safety distance that it keeps under `communication_aware`.
    return Gains(**{**numbers, "barrier": 1.0, "spacing_m": float(_Aware().spacing_m)})
