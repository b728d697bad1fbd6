"""
A formation by displacements: every vehicle keeps its offset from those by which it steers.

    u    = w + w_i' + barrier( limited( g k (p_d - p), u_max ))
    p_d  = w_i + sum_j W_ij (p_j - w_j)        leader: path + w_i
    g    = min(1, phi / A),  A the mean age of the packets of the vehicles j

w is the flock's velocity: the leader's path velocity, passed on as in `communication_aware`, and turned since
its stamp. w_i is the offset of the own slot in the frame that turns with the course of w. W has the reference
type (thesis Section 1.7.2.2; `auv_control.formations.references`).

1. The shape may switch to another at a given time. Vehicles take the slots with the smallest sum of squared
   distances, and their offsets move on a quintic, so that ways stay apart by d / sqrt(2).
2. A vehicle of which no news is younger than `lost_after_s` is lost. The others take the slots of the smaller
   formation. News at second hand count: a report says from whom its sender has heard lately.
3. The lowest live address leads. If it knows the path it follows it. Else it goes on with the flock's last
   velocity, turning as that did: it defines where the formation is.
4. The barrier is that of `communication_aware`. A lost vehicle is an obstacle where it was last heard. A
   vehicle near it steps aside to the right, since a barrier alone would hold one that comes straight at it.

Source: thesis Sections 1.7.2, 1.10.2 to 1.10.4. Deviation: the thesis gives no law for these; feedback on
displacements is Oh, Park and Ahn (2015), A survey of multi-agent formation control. The velocity is the
leader's, passed on, and not that of the vehicles by which one steers: over acoustic links theirs is the most
uncertain part of an estimate, and errors then do not grow along a string.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from auv_control.formations.frame import Course, Offset, world_offset
from auv_control.formations.references import TYPES, reference_weights
from auv_control.formations.shapes import NO_SLOT, SHAPES, Slots, shape_slots
from auv_control.formations.targets import Guide, desired_motion, guide_of_path
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
    AGE,
    FLOCK_STAMP,
    FLOCK_TURN_RATE,
    FLOCK_VELOCITY,
    Estimates,
    Neighbours,
)
from auv_flocking.separation import SeparationLaw

NO_SHAPE = "none"
_NOTICE_EVERY_S = 1.0
_STANDS_MPS = 1e-3
_Aware = communication_aware.Params


@dataclass(frozen=True)
class Params:
    """The module explains the symbols."""

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
    leader_share: float = param(
        "share of the leader in the references; the three sum to 1", default=0.5, minimum=0.0, maximum=1.0
    )
    predecessor_share: float = param(
        "share of the predecessor in the references", default=0.5, minimum=0.0, maximum=1.0
    )
    neighbour_share: float = param(
        "share of the neighbours in the shape in the references", default=0.0, minimum=0.0, maximum=1.0
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
        """Refuse shares that do not sum to 1, incomplete offsets, and a barrier wider than the formation."""
        reference_weights(self.shares, (NO_SLOT, 0))
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
        """The share of each type of reference."""
        return dict(
            zip(TYPES, (self.leader_share, self.predecessor_share, self.neighbour_share), strict=True)
        )

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
            return tuple((x[3 * i], x[3 * i + 1], x[3 * i + 2]) for i in range(count))
        return shape_slots(shape, count, self.spacing_m, math.radians(self.half_angle_deg))

    def next_slots(self, count: int) -> Slots:
        """Return the offsets of the shape to switch to (m)."""
        return self.slots(self.next_shape, count)


class Flocking(FlockingLaw):
    """The law of one vehicle; its state is what it knows of the fleet, and the slots that follow from it."""

    def __init__(self, params: Params, separation: SeparationLaw, member: Member) -> None:
        del separation  # the barrier keeps distances
        count = len(params.offsets_m) // 3
        if count and count < member.fleet_size:
            raise ValueError(
                f"offsets_m: those of {count} vehicles are not allowed; allowed: one for each of the "
                f"{member.fleet_size}"
            )
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
        own = world_offset(self.roster.offset(self._member.address, self._t_s), course)
        guides, age_s = self._guides(view, estimates, course)
        asked = own.velocity
        if guides:
            wanted = desired_motion(own, guides, uses_accelerations=False).position
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

    def _course(self, flock: Vec3) -> Course:
        """Return the course of the flock; one that stands keeps its last."""
        if math.hypot(flock[0], flock[1]) > _STANDS_MPS:
            self._chi_rad = math.atan2(flock[1], flock[0])
        return Course(self._chi_rad, self._turn_rate_radps)

    def _guides(self, view: View, estimates: Estimates, course: Course) -> tuple[list[Guide], float]:
        """
        Return the vehicles by which this one steers, and the mean age of their packets (s).

        Weights of vehicles of which there is no estimate go to the others. There are none for a leader that
        does not know the path, and for a vehicle that knows none of them.
        """
        p, order = self._params, self.roster.order
        if self.leads:
            path = [guide_of_path(1.0, view.path)] if self._member.is_leader else []
            return path, p.response_s
        weights = order.weights.others[order.slots[self._member.address]]
        known = [
            (weights[order.slots[address]], index, address)
            for index, address in enumerate(estimates.addresses)
            if address in order.slots and weights[order.slots[address]] > 0.0
        ]
        total = sum(weight for weight, _, _ in known)
        places, ages_s = estimates.positions(), estimates.column(AGE)
        guides = [
            Guide(
                weight / total,
                Offset(places[index]),
                world_offset(self.roster.offset(address, self._t_s), course),
            )
            for weight, index, address in known
        ]
        age_s = sum(weight * ages_s[index] for weight, index, _ in known) / total if known else 0.0
        return guides, max(age_s, p.response_s)

    def adapt(self, view: View, dt_s: float) -> None:
        """Do nothing: this law has no separation law that adapts."""


def roster_of(params: Params, member: Member) -> Roster:
    """Return the order of a fleet at the start, as one vehicle keeps it."""
    slots_of = partial(params.slots, params.shape)
    return Roster(member, params.shares, slots_of, params.lost_after_s, params.move_s)


def _gains(p: Params) -> Gains:
    """Return the parameters of the barrier; those of the rest of `communication_aware` do not count."""
    numbers = {name: float(getattr(p, name, 0.0)) for name in Gains._fields}
    # An obstacle keeps the share of its safety distance that it keeps under `communication_aware`.
    return Gains(**{**numbers, "barrier": 1.0, "spacing_m": float(_Aware().spacing_m)})
