"""
Turning away on the way to the lane: the second barrier, for starts at one depth and for shallow water.

Once a second a vehicle in TRANSIT compares 13 courses, its own one and up to 6 pi / 7 to each side, held for
some seconds and then given up for the way to its lane. Each is rolled out against the *intent* of every
neighbour: the same guidance, from its last packet, at its reported speed, with the course that it says it has
turned to.

    cost = |off| / pi + 0.1 (to port) + 0.15 |change| / pi + 6 max over tau of share (1 - tau / 2 T)

share is how far a neighbour comes inside D_k + sigma, per D_k + sigma, while less than the conflict height
away in depth. sigma grows with the age of the packet. Priority is by address: a vehicle gives way to all that
are in their lanes, and to those in TRANSIT with a lower address. If both gave way, they would turn into each
other before their first packets. To vehicles with another task, such as one that hovers, it always gives way;
of them it knows position and velocity, and takes it that they go straight on. It lowers the risk and gives no
guarantee, which layers do.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from auv_control.guidance.track import Track, newton_step, piece_at, point_at, seen_from
from auv_core.compiled import entry, fastest, record
from auv_core.geometry import Vec3, clipped, smallest_angle
from auv_core.params import param
from auv_flocking.lanes.modes import IN_LANE
from auv_flocking.lanes.status import COURSES, STRAIGHT_ON, LaneNeighbour
from auv_flocking.neighbours.estimates import NeighbourEstimate

Floats = NDArray[np.float64]

_SUBSTEP_S = 0.5


@dataclass(frozen=True)
class Params:
    """How far to look ahead, and what counts as a conflict."""

    kind: str = param(
        "whether vehicles on the way to their lanes turn away from others",
        default="none",
        choices=("none", "intent_vo"),
    )
    every_s: float = param("time between two decisions (s)", default=1.0, above=0.0)
    held_s: float = param("how long a course is held (s)", default=20.0, above=0.0)
    horizon_s: float = param("how far to look ahead (s)", default=45.0, above=0.0, maximum=600.0)
    distance_m: float = param("distance of a conflict D_k (m)", default=13.0, above=0.0)
    height_m: float = param("difference of depth of a conflict (m)", default=5.5, above=0.0)
    sigma_m: float = param("uncertainty of a fresh packet (m)", default=1.0, minimum=0.0)
    sigma_rate_mps: float = param("growth of the uncertainty (m/s)", default=0.03, minimum=0.0)
    sigma_avoiding_mps: float = param(
        "additional growth for a neighbour that turns away (m/s)", default=0.1, minimum=0.0
    )
    sigma_max_m: float = param("largest uncertainty (m)", default=15.0, minimum=0.0)
    sigma_in_lane_m: float = param("uncertainty of a neighbour in its lane (m)", default=0.5, minimum=0.0)
    lookahead_m: float = param("lookahead distance of the guidance (m)", default=10.0, above=0.0)
    turn_rate_radps: float = param(
        "largest turn rate (rad/s)", default=math.radians(3.8), above=0.0, maximum=10.0
    )
    course_time_s: float = param("time constant of the course (s)", default=1.2, above=0.0)
    descent_mps: float = param("vertical speed (m/s)", default=0.35, above=0.0)
    settles_s: float = param(
        "time after which a neighbour flies at the speed of the fleet (s)", default=40.0, minimum=0.0
    )


@record(", ".join(10 * ["float64"]))
class Intent(NamedTuple):
    """
    Where a vehicle is and what it is going to do.

    Position (m; NED), course over ground (rad), speed over ground (m/s), path parameter near it and lane (m),
    depth to which it goes (m), and the course that it holds beside its guidance (rad) for some time more (s).
    """

    north_m: float
    east_m: float
    depth_m: float
    course_rad: float
    speed_mps: float
    s_m: float
    lane_m: float
    depth_target_m: float
    offset_rad: float
    offset_s: float


@record(", ".join(5 * ["float64"]))
class Law(NamedTuple):
    """Lookahead (m), turn rate (rad/s), time constant (s), vertical speed (m/s), round (m; 0: open)."""

    lookahead_m: float
    turn_rate_radps: float
    course_time_s: float
    descent_mps: float
    round_m: float


class Way(NamedTuple):
    """The way of a neighbour, one row per second from now on (m; NED), and its uncertainty (m)."""

    points: Floats
    sigma_m: float


def course_offset_rad(index: int) -> float:
    """Return the angle of one of the courses (rad, to starboard)."""
    return (index - STRAIGHT_ON) * math.pi / 7.0


def uncertainty_m(age_s: float, params: Params, *, avoids: bool, in_lane: bool) -> float:
    """Return sigma for a packet of an age (s), from a neighbour that avoids others or is in its lane."""
    if in_lane:
        return params.sigma_in_lane_m
    rate = params.sigma_rate_mps + (params.sigma_avoiding_mps if avoids else 0.0)
    return min(params.sigma_m + rate * age_s, params.sigma_max_m)


@entry("void(Intent, float64, float64, float64[:, ::1], Law, float64[:, ::1])", allocates=False)
def roll_out(
    start: Intent, settled_mps: float, settles_s: float, pieces: Floats, law: Law, out: Floats
) -> None:
    """
    Write the way of a vehicle, one row per second from now on: position (m; NED).

    Parameters
    ----------
    start : Intent
        The vehicle now.
    settled_mps, settles_s : float
        Speed (m/s) that it has after some time (s).
    pieces : (n, 6) array
        The track.
    law : Law
        Of guidance and course.
    out : (m, 3) array
        Output.

    """
    north_m, east_m, depth_m = start.north_m, start.east_m, start.depth_m
    course, s_m, speed_mps = start.course_rad, start.s_m, start.speed_mps
    substeps = round(1.0 / _SUBSTEP_S)
    for step in range(substeps * (len(out) - 1) + 1):
        if step % substeps == 0:
            row = step // substeps
            out[row, 0], out[row, 1], out[row, 2] = north_m, east_m, depth_m
        t_s = step * _SUBSTEP_S
        if t_s >= settles_s:
            speed_mps = settled_mps
        point = point_at(pieces, law.round_m, piece_at(pieces, law.round_m, s_m), s_m)
        seen = seen_from(point, north_m, east_m)
        s_m += newton_step(seen, point.curvature_pm)
        wanted = point.course_rad - math.atan((seen.across_m - start.lane_m) / law.lookahead_m)
        if t_s < start.offset_s:
            wanted += start.offset_rad
        rate = clipped(smallest_angle(wanted - course) / law.course_time_s, law.turn_rate_radps)
        course += _SUBSTEP_S * rate
        north_m += _SUBSTEP_S * speed_mps * math.cos(course)
        east_m += _SUBSTEP_S * speed_mps * math.sin(course)
        depth_m += clipped(start.depth_target_m - depth_m, _SUBSTEP_S * law.descent_mps)


@entry("float64(float64[:, ::1], float64[:, ::1], float64, float64, float64)", allocates=False)
def conflict(own: Floats, other: Floats, distance_m: float, height_m: float, horizon_s: float) -> float:
    """Return how much a way conflicts with another one, 0 to 1: sooner and closer counts more."""
    worst = 0.0
    for k in range(len(own)):
        if abs(own[k, 2] - other[k, 2]) < height_m:
            north_m, east_m = own[k, 0] - other[k, 0], own[k, 1] - other[k, 1]
            share = 1.0 - math.sqrt(north_m * north_m + east_m * east_m) / distance_m
            worst = max(worst, share * (1.0 - 0.5 * k / horizon_s))
    return worst


class TurnAway:
    """
    The courses of one vehicle; `course` is the one that it holds, 0 to 12, and 6 is straight on to the lane.

    Parameters
    ----------
    params : Params
        Of the law.
    track : Track
        The track of the fleet.
    slots : sequence of (3,) tuple
        Offsets of all slots (m; along the course, to starboard, down), in the order of addresses.
    address : int
        The vehicle's own.
    speed_mps : float
        Speed of the fleet along the track (m/s).

    """

    def __init__(
        self, params: Params, track: Track, slots: Sequence[Vec3], address: int, speed_mps: float
    ) -> None:
        self._params, self._pieces, self._slots = params, track.rows, slots
        self._address, self._speed_mps = address, speed_mps
        self._law = Law(
            params.lookahead_m,
            params.turn_rate_radps,
            params.course_time_s,
            params.descent_mps,
            track.round_m,
        )
        self._roll_out, self._conflict = fastest(roll_out), fastest(conflict)
        self._rows = int(params.horizon_s) + 1
        self._decided_s = -math.inf
        self.course = STRAIGHT_ON

    def decide(
        self,
        t_s: float,
        own: Intent,
        neighbours: Iterable[LaneNeighbour],
        others: Iterable[NeighbourEstimate] = (),
    ) -> float:
        """
        Return the angle beside the way to the lane (rad), decided anew once per `every_s`.

        Parameters
        ----------
        t_s : float
            Time (s).
        own : Intent
            The own vehicle, without a course beside its guidance.
        neighbours : iterable of LaneNeighbour
            All of the fleet that are known.
        others : iterable of NeighbourEstimate
            Vehicles with another task.

        """
        if t_s - self._decided_s >= self._params.every_s - 1e-9:
            self._decided_s = t_s
            ways = [self._way_of(other, t_s) for other in neighbours if self._gives_way_to(other)]
            ways += [self._straight_way_of(other) for other in others]
            self.course = self._chosen(own, ways)
        return course_offset_rad(self.course)

    def give_up(self) -> None:
        """Go straight on: the vehicle is in its lane."""
        self.course, self._decided_s = STRAIGHT_ON, -math.inf

    def _gives_way_to(self, other: LaneNeighbour) -> bool:
        return other.status.mode in IN_LANE or other.address < self._address

    def _chosen(self, own: Intent, ways: Sequence[Way]) -> int:
        p, costs = self._params, []
        for index in range(COURSES):
            offset_rad = course_offset_rad(index)
            held = own._replace(offset_rad=offset_rad, offset_s=p.held_s)
            points = self._points(held, own.speed_mps, 0)
            risks = [
                self._conflict(points, way.points, p.distance_m + way.sigma_m, p.height_m, p.horizon_s)
                for way in ways
            ]
            change = abs(index - self.course) / 7.0
            port = 0.1 if index < STRAIGHT_ON else 0.0
            cost = abs(offset_rad) / math.pi + port + 0.15 * change + 6.0 * max(risks, default=0.0)
            costs.append((cost, abs(index - STRAIGHT_ON), index))
        return min(costs)[2]

    def _way_of(self, other: LaneNeighbour, t_s: float) -> Way:
        """Return the way of a neighbour from now on, rolled out from its last packet."""
        p, status = self._params, other.status
        along_m, lane_m, _ = self._slots[other.address - 1]
        north_mps, east_mps, _ = other.velocity
        avoids = status.turn_away_course != STRAIGHT_ON
        intent = Intent(
            *other.position,
            math.atan2(east_mps, north_mps),
            math.hypot(north_mps, east_mps),
            status.gamma_m + along_m,
            lane_m,
            status.depth_target_m,
            course_offset_rad(status.turn_away_course),
            p.held_s if avoids else 0.0,
        )
        sigma_m = uncertainty_m(t_s - other.time_s, p, avoids=avoids, in_lane=status.mode in IN_LANE)
        return Way(self._points(intent, self._speed_mps, round(t_s - other.seen_s)), sigma_m)

    def _straight_way_of(self, other: NeighbourEstimate) -> Way:
        """Return the way of a vehicle with another task, straight on from now."""
        ahead_s = np.arange(self._rows, dtype=np.float64)[:, np.newaxis]
        sigma_m = uncertainty_m(other.age_s, self._params, avoids=False, in_lane=False)
        return Way(np.array(other.position) + ahead_s * np.array(other.velocity), sigma_m)

    def _points(self, intent: Intent, settled_mps: float, age_rows: int) -> Floats:
        way = np.empty((self._rows + age_rows, 3))
        self._roll_out(intent, settled_mps, self._params.settles_s, self._pieces, self._law, way)
        return way[age_rows:]
