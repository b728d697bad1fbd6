"""An active sonar: range, bearing and elevation of all hulls and obstacles in range, without identity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter

from auv_core.geometry import Vec3, ned_to_body
from auv_core.messages import SonarContact, VehicleState
from auv_core.params import param
from auv_sim.acoustics.sonar import HullSonar
from auv_sim.streams import Purpose, generator

_SLACK_PINGS = 1e-6
_BLOCK_TICKS = 64

_MOST_OBSTACLES = 1 << 20

_Luck = list[tuple[float, float, float, float]]
_Stream = tuple[Purpose, int]  # of one observer and one target


@dataclass(frozen=True)
class Params:
    """Range, rate, accuracy (one sigma) and field of view."""

    max_range_m: float = param(
        "largest distance of a visible hull or obstacle centre (m)", default=10.0, above=0.0
    )
    rate_hz: float = param("pings per second; at most one per control period", default=2.0, above=0.0)
    range_sd_m: float = param("standard deviation of a range (m)", default=0.1, minimum=0.0, maximum=100.0)
    angle_sd_rad: float = param(
        "standard deviation of bearing and elevation (rad)",
        default=math.radians(1.0),
        minimum=0.0,
        maximum=1.0,
    )
    detection_prob: float = param(
        "probability that a ping detects a hull or an obstacle in view", default=0.9, minimum=0.0, maximum=1.0
    )
    horizontal_view_rad: float = param(
        "width of the field of view, centred on the bow (rad)",
        default=2.0 * math.pi,
        above=0.0,
        maximum=2.0 * math.pi,
    )
    vertical_view_rad: float = param(
        "height of the field of view, centred on the body's horizontal plane (rad)",
        default=math.pi,
        above=0.0,
        maximum=math.pi,
    )


class Sonar(HullSonar):
    """
    Detects the centres of hulls and obstacles from the own hull centre, in the body frame of the true
    attitude at the tick.

    The hulls of lost vehicles are detected, too. Nothing hides anything else, travel time is neglected, and
    there are no false contacts. The nearest contact comes first.
    """

    def __init__(self, params: Params, seed: int) -> None:
        self._params = params
        self._seed = seed
        self._blocks: dict[_Stream, tuple[int, _Luck]] = {}

    def contacts(
        self,
        address: int,
        tick: int,
        period_s: float,
        states: Sequence[VehicleState],
        obstacles: Sequence[Vec3] = (),
    ) -> tuple[SonarContact, ...]:
        """
        Return the contacts of vehicle `address` at a tick, the nearest first.

        Parameters
        ----------
        address : int
            The observer's address, from 1.
        tick : int
            The control tick.
        period_s : float
            Control period (s).
        states : sequence of VehicleState
            The true states at the tick, in the order of addresses.
        obstacles : sequence of (3,) tuple
            The true positions of the obstacles at the tick (m; NED).

        Returns
        -------
        contacts : tuple of SonarContact
            Empty in a tick without a ping. There is a ping if a multiple of 1 / rate lies between this tick
            and the next.

        """
        if not self._pings(tick, period_s):
            return ()
        own = states[address - 1]
        x, y, z = own.position
        reach_m2 = self._params.max_range_m * self._params.max_range_m
        hulls = (
            ((Purpose.SONAR, 256 * address + index + 1), state.position)
            for index, state in enumerate(states)
            if index != address - 1
        )
        things = (
            ((Purpose.OBSTACLE_SONAR, _MOST_OBSTACLES * address + index), position)
            for index, position in enumerate(obstacles)
        )
        found = []
        for stream, position in (*hulls, *things):
            north, east, down = position[0] - x, position[1] - y, position[2] - z
            if north * north + east * east + down * down <= reach_m2:
                contact = self._contact(ned_to_body(own.attitude, (north, east, down)), stream, tick)
                if contact is not None:
                    found.append(contact)
        return tuple(sorted(found, key=attrgetter("range_m", "bearing_rad", "elevation_rad")))

    def _pings(self, tick: int, period_s: float) -> bool:
        pings_per_tick = self._params.rate_hz * period_s
        #  Number of pings before a tick, with a tolerance, so that a ping on a tick belongs to that tick
        # despite rounding. The same sum ends one tick and begins the next, so that no ping is lost or
        # doubled.
        before = math.ceil(tick * pings_per_tick - _SLACK_PINGS)
        return math.ceil((tick + 1) * pings_per_tick - _SLACK_PINGS) > before

    def _contact(self, body: Vec3, stream: _Stream, tick: int) -> SonarContact | None:
        """Return the contact of a target at `body` (m; FRD), or None if it is out of view or missed."""
        p = self._params
        level_m = math.hypot(body[0], body[1])
        bearing_rad, elevation_rad = math.atan2(body[1], body[0]), math.atan2(-body[2], level_m)
        if 2.0 * abs(bearing_rad) > p.horizontal_view_rad or 2.0 * abs(elevation_rad) > p.vertical_view_rad:
            return None
        chance, first, second, third = self._luck(stream, tick)
        if chance >= p.detection_prob:
            return None
        return _in_range(
            max(0.0, math.hypot(level_m, body[2]) + p.range_sd_m * first),
            bearing_rad + p.angle_sd_rad * second,
            elevation_rad + p.angle_sd_rad * third,
        )

    def _luck(self, stream: _Stream, tick: int) -> tuple[float, float, float, float]:
        """
        Return one number uniform on [0, 1) and three standard normal ones, fixed by seed, stream and tick.

        They are drawn for many ticks at once, which takes a tenth of the time.
        """
        block = tick // _BLOCK_TICKS
        drawn, rows = self._blocks.get(stream, (-1, []))
        if drawn != block:
            rng = generator(self._seed, *stream, block)
            chances = rng.random(_BLOCK_TICKS).tolist()
            normals = rng.standard_normal((_BLOCK_TICKS, 3)).tolist()
            rows = [(chance, *row) for chance, row in zip(chances, normals, strict=True)]
            self._blocks[stream] = (block, rows)
        return rows[tick % _BLOCK_TICKS]


def _in_range(range_m: float, bearing_rad: float, elevation_rad: float) -> SonarContact:
    """Return the contact with its elevation in [-pi/2, pi/2] and its bearing in [-pi, pi]."""
    elevation_rad = math.remainder(elevation_rad, 2.0 * math.pi)
    if abs(elevation_rad) > 0.5 * math.pi:  # past the zenith
        elevation_rad = math.copysign(math.pi, elevation_rad) - elevation_rad
        bearing_rad += math.pi
    return SonarContact(range_m, math.remainder(bearing_rad, 2.0 * math.pi), elevation_rad)
