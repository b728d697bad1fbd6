"""
Neighbour estimates of a vehicle: from late or lost packets, unidentified sonar contacts and its own
navigation to one estimate per neighbour and tick.

The parts: `motion` (how neighbours move), `navigation_offset` (what drifting navigations do), `sonar_contact`
(the sonar's measurement model), `filter` (the extended Kalman filter), `association` (which contact belongs
to which neighbour), `track` (one neighbour through time). docs/explanation/estimation.md explains the whole.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import fastest
from auv_core.geometry import body_to_ned
from auv_core.messages import SonarContact, VehicleState
from auv_flocking.neighbours.estimates import (
    AGE,
    COVARIANCE,
    POSITION,
    SOURCE_WIDTH,
    VELOCITY,
    WIDTH,
    Estimates,
    carried_to,
)
from auv_flocking.neighbours.filter import NeighbourConfig, NeighbourFilter
from auv_flocking.neighbours.navigation_offset import OwnFix, Stated
from auv_flocking.neighbours.rivals import NO_RIVALS, Leftovers, Rivals, leftovers
from auv_flocking.neighbours.sonar_contact import is_contact, sighting
from auv_flocking.neighbours.track import HISTORY_S, HeardReport, Track
from auv_flocking.report import Report

if TYPE_CHECKING:
    from auv_flocking.neighbours.association import Pairing

__all__ = [
    "NeighbourConfig",
    "NeighbourTable",
]

_Said = tuple[list[int], list[tuple[float, ...]], NDArray[np.int64]]

_FIX_RATIO = 0.95
_SONAR_REACH_M = 10.0
_UNHEARD = 2.0 * math.log(4.0 / 3.0 * math.pi * _SONAR_REACH_M**3) - 3.0 * math.log(2.0 * math.pi)
"""d^2 + ln det S of a vehicle that may be anywhere within the reach of a sonar."""


class _OwnNavigation:
    """Recent variances that the own navigation stated, and its fixes."""

    def __init__(self) -> None:
        self._times_s: list[float] = []
        self._variances_m2: list[float] = []
        self._last: tuple[float, VehicleState] | None = None

    def note(self, t_s: float, nav: VehicleState) -> OwnFix | None:
        """Note the navigation at `t_s`; return the fix since the last call, if any."""
        last, self._last = self._last, (t_s, nav)
        if last is not None and last[0] == t_s:
            return None
        variance_m2 = nav.position_sd_m * nav.position_sd_m
        if variance_m2 == 0.0 and not self._times_s:
            return None
        self._times_s.append(t_s)
        self._variances_m2.append(variance_m2)
        if self._times_s[0] < t_s - 2.0 * HISTORY_S:
            old = bisect.bisect_left(self._times_s, t_s - HISTORY_S)
            del self._times_s[:old], self._variances_m2[:old]
        if last is None or nav.position_sd_m >= _FIX_RATIO * last[1].position_sd_m:
            return None
        return OwnFix(t_s, _jump(*last, t_s, nav), last[1].position_sd_m ** 2, variance_m2)

    def variance_m2(self, t_s: float) -> float:
        """Return the variance of the own position, per horizontal axis, as stated at `t_s` (m^2)."""
        if not self._times_s:
            return 0.0
        return self._variances_m2[max(bisect.bisect_right(self._times_s, t_s) - 1, 0)]


def _jump(before_s: float, before: VehicleState, t_s: float, nav: VehicleState) -> tuple[float, float]:
    """Return the jump of the position beyond the motion by the mean velocity (m; north, east)."""
    half_s = 0.5 * (t_s - before_s)
    v0, v1 = (body_to_ned(state.attitude, state.nu[:3]) for state in (before, nav))
    return (
        nav.position[0] - before.position[0] - half_s * (v0[0] + v1[0]),
        nav.position[1] - before.position[1] - half_s * (v0[1] + v1[1]),
    )


def _pairing(config: NeighbourConfig) -> Callable[..., Pairing]:
    """Return `associate` with the gate of a configuration; vehicles without a sonar never load it."""
    from auv_flocking.neighbours.association import associate, chi_square_gate

    return partial(associate, gate=chi_square_gate(config.gate_prob), margin=config.rival_margin)


class NeighbourTable:
    """
    The neighbours of one vehicle. Its only inputs are those of the vehicle itself, so that the estimates of
    a recorded run can be computed again without the simulator.

    `outdated`: packets that were repetitions or too old to be used; `contacts_used`, `contacts_unknown`:
    sonar contacts with and without an associated neighbour; `contacts_refused`: implausible ones, and all of
    a vehicle without a sonar.
    """

    def __init__(self, config: NeighbourConfig, *, has_sonar: bool = True) -> None:
        self._config = config
        self._filter = NeighbourFilter(config)
        self._own = _OwnNavigation()
        self._tracks: dict[int, Track] = {}
        self._in_order: list[Track] = []
        self._rows: dict[Track, int] = {}
        self._sources = np.empty((0, SOURCE_WIDTH))
        self._source_of = np.empty(0, dtype=np.int64)
        self._said: _Said = ([], [], np.empty(0, dtype=np.int64))
        self._stale: set[Track] = set()
        self._carried_to = fastest(carried_to)
        self._pairing = _pairing(config) if has_sonar else None
        self.outdated = 0
        self.contacts_used = 0
        self.contacts_unknown = 0
        self.contacts_refused = 0

    @property
    def heard(self) -> int:
        """Number of neighbours heard at least once."""
        return len(self._tracks)

    @property
    def tracks(self) -> list[Track]:
        """The neighbours heard at least once, in the order of addresses."""
        return self._in_order

    def receive(self, report: Report) -> None:
        """
        Use one report. Reports come in the order of arrival, which may differ from that of their time tags.
        """
        own_m2 = self._own.variance_m2(report.time_s)
        stated = Stated(own_m2, report.position_sd_m * report.position_sd_m)
        heard = HeardReport(report, stated)
        track = self._tracks.get(report.address)
        if track is None:
            self._add(report.address, Track(heard, self._filter, self._config.velocity_memory_s))
        elif track.hear(heard):
            self._stale.add(track)
        else:
            self.outdated += 1

    def _add(self, address: int, track: Track) -> None:
        """Add a neighbour that is heard for the first time; the rows of the others stay."""
        self._tracks[address] = track
        self._in_order = [each for _, each in sorted(self._tracks.items())]
        self._rows = {each: row for row, each in enumerate(self._in_order)}
        row, addresses, shared = self._rows[track], sorted(self._tracks), self._said[1].copy()
        shared.insert(row, ())
        self._sources = np.insert(self._sources, row, 0.0, axis=0)
        self._source_of = np.empty(len(addresses), dtype=np.int64)
        self._said = (addresses, shared, np.array(addresses))
        self._stale.add(track)

    def observe(
        self,
        t_s: float,
        nav: VehicleState,
        contacts: Sequence[SonarContact],
        rivals: Rivals = NO_RIVALS,
        *,
        has_unheard: bool = False,
    ) -> Leftovers:
        """
        Use the sonar contacts of one tick, relative to the pose of the own navigation.

        `rivals` are other objects that contacts may belong to; what belongs to no neighbour is returned. If
        the fleet has a vehicle that was never heard (`has_unheard`), it may be anywhere, and with
        `rival_margin` it competes for contacts, too.
        """
        self.follow(t_s, nav)
        pairing = self._pairing
        possible = [] if pairing is None else [contact for contact in contacts if is_contact(contact)]
        self.contacts_refused += len(contacts) - len(possible)
        config = self._config
        sightings = [
            sighting(t_s, nav, contact, config.sonar_range_std_m, config.sonar_angle_std_rad)
            for contact in possible
        ]
        known = self._carried(t_s)
        points, covariances = (
            known.rows[:, POSITION:VELOCITY],
            known.rows[:, COVARIANCE:AGE].reshape(-1, 6, 6)[:, :3, :3],
        )
        pairs, doubtful = (
            ([], [])
            if pairing is None
            else pairing(
                np.array([seen.point for seen in sightings]),
                np.array([seen.covariance for seen in sightings]),
                np.concatenate((points, rivals.points)),
                np.concatenate((covariances, rivals.covariances)),
                bound=self._bound(rivals, has_unheard),
            )
        )
        for contact, owner in pairs:
            if owner < len(known):
                track = self._tracks[known.addresses[owner]]
                track.see(sightings[contact])
                self._stale.add(track)
        n_used = sum(owner < len(known) for _, owner in pairs)
        self.contacts_used += n_used
        self.contacts_unknown += len(possible) - n_used
        return leftovers(sightings, pairs, doubtful, points, covariances)

    def _bound(self, rivals: Rivals, has_unheard: bool) -> float:
        margin = self._config.rival_margin
        return min(rivals.bound, _UNHEARD - margin) if margin > 0.0 and has_unheard else rivals.bound

    def estimates(self, t_s: float, nav: VehicleState | None = None) -> Estimates:
        """
        Return the neighbours heard or seen within the time-out, extrapolated to `t_s`, in the order of
        addresses.

        `nav` is the own navigation at that time, or None if it has no solution.
        """
        if nav is not None:
            self.follow(t_s, nav)
        return self._carried(t_s)

    def _carried(self, t_s: float) -> Estimates:
        if self._stale:
            self._write_stale()
        config, sources, source_of = self._config, self._sources, self._source_of
        rows = np.empty((len(sources), WIDTH))
        n = self._carried_to(t_s, config.velocity_memory_s, config.timeout_s, sources, rows, source_of)
        addresses, shared, numbers = self._said
        if n == len(sources):
            return Estimates(addresses, rows, shared, numbers)
        who = source_of[:n].tolist()
        return Estimates([addresses[k] for k in who], rows[:n], [shared[k] for k in who])

    def _write_stale(self) -> None:
        """Write changes since the last call into the sources."""
        addresses, shared, numbers = self._said
        shared = shared.copy()
        for track in self._stale:
            row = self._rows[track]
            track.write(self._sources[row])
            shared[row] = track.report.shared
        self._said = (addresses, shared, numbers)
        self._stale.clear()

    def follow(self, t_s: float, nav: VehicleState) -> OwnFix | None:
        """Note the own navigation; return its fix since the last call, if any."""
        fix = self._own.note(t_s, nav)
        if fix is not None:
            for track in self._tracks.values():
                track.move_frame(fix)
            self._stale.update(self._in_order)
        return fix
