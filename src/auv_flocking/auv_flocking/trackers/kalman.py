"""
Obstacle tracks from sonar contacts: a Kalman filter each, confirmed after several contacts, forgotten later.

A contact carries no identity, so the rules decide what it is.

1. Neighbours, known obstacles and tracks compete for contacts in one association (`neighbours.association`).
   A pair counts only if it is more likely than a new object: P(z) > lambda, with P the density of the contact
   by the estimate and lambda the density of unknown objects, that is d^2 + ln det S < -2 ln lambda - 3 ln
   2 pi. So a neighbour that was not heard for a minute, and may be anywhere, takes no contact of an obstacle.
2. Every other contact begins a track. It is confirmed by `confirm_contacts` contacts within `confirm_s`, or
   else dropped. A confirmed one is forgotten `forget_s` after its last contact.
3. Two objects at one place give two contacts. If a track is at the place of a neighbour or an older track,
   and of the two only one gets a contact, `_DOUBTS` times before both get one, the track *is* the other, and
   is dropped. This is how a vehicle that was seen before it was heard ceases to be an obstacle.
4. A known obstacle takes contacts only where the vehicle expects them. If the own navigation drifted, the
   same obstacle is tracked where it is seen, too.

State: position and velocity (m, m/s; NED) in the frame of the own navigation; white acceleration of density
q, so that still and moving obstacles need no different model. A drift of the own navigation is a velocity of
the obstacle here, and a fix moves all tracks.

Source: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), sections
5.2 and 10.4.3; Blackman, Popoli, Design and Analysis of Modern Tracking Systems (1999), section 6.2 (rule 1:
the density of new targets).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from auv_core.geometry import Vec3
from auv_core.params import param
from auv_flocking.neighbours.association import chi_square_gate, distances
from auv_flocking.neighbours.kalman import predicted, updated
from auv_flocking.neighbours.motion import process_noise, transition_matrix
from auv_flocking.neighbours.navigation_offset import OwnFix
from auv_flocking.neighbours.rivals import Leftovers, Rivals
from auv_flocking.neighbours.sonar_contact import Sighting
from auv_flocking.trackers import ObstacleTracker, Sensed, SensedObstacle

Matrix = NDArray[np.float64]

_DOUBTS = 3
_H = np.eye(3, 6)
_KNOWN_M2 = 0.1**2 * np.eye(3)
_SAME_PLACE = chi_square_gate(0.99)


@dataclass(frozen=True)
class Params:
    """What is assumed of obstacles, and when a track counts."""

    safety_distance_m: float = param(
        "distance at which a vehicle begins to avoid what it senses (m)", default=2.0, above=0.0
    )
    confirm_contacts: int = param("contacts that confirm an obstacle", default=3, minimum=1, maximum=100)
    confirm_s: float = param("time within which they must come (s)", default=5.0, above=0.0)
    forget_s: float = param("time without a contact after which it is forgotten (s)", default=20.0, above=0.0)
    acceleration_psd: float = param(
        "spectral density of an obstacle's acceleration (m^2/s^3)", default=1e-4, above=0.0
    )
    speed_sd_mps: float = param(
        "standard deviation of the velocity of a new track, per axis (m/s)", default=0.2, above=0.0
    )
    unknown_density_pm3: float = param(
        "density of unknown objects in the water (1/m^3)", default=1e-3, above=0.0
    )

    @property
    def bound(self) -> float:
        """Largest d^2 + ln det S of a contact and its object."""
        return -2.0 * math.log(self.unknown_density_pm3) - 3.0 * math.log(2.0 * math.pi)


@dataclass
class _Track:
    """One object: its estimate at `time_s`, the times of its first contacts, its newest contact."""

    number: int
    time_s: float
    x: Matrix
    P: Matrix
    first_s: list[float] = field(default_factory=list)
    seen_s: float = 0.0
    is_confirmed: bool = False
    doubts: int = 0


class _Objects(NamedTuple):
    """Neighbours, then tracks: where they are (m, m^2; NED), and which of them took a contact."""

    points: Matrix
    covariances: Matrix
    is_seen: NDArray[np.bool_]


class Tracker(ObstacleTracker):
    """The obstacle tracks of one vehicle."""

    def __init__(self, params: Params, known: tuple[Vec3, ...]) -> None:
        self._params = params
        self._known = np.array(known, dtype=np.float64).reshape(-1, 3)
        self._tracks: list[_Track] = []
        self._started = 0

    def follow(self, fix: OwnFix) -> None:
        """Move every track by the jump of the own position."""
        for track in self._tracks:
            track.x = track.x + np.array((*fix.jump, 0.0, 0.0, 0.0, 0.0))

    def rivals(self, t_s: float) -> Rivals:
        """Return the known obstacles, and then the tracks."""
        self._forget(t_s)
        now = [self._at(track, t_s) for track in self._tracks]
        return Rivals(
            np.array([*self._known, *(x[:3] for x, _ in now)]).reshape(-1, 3),
            np.array([*(_KNOWN_M2 for _ in self._known), *(P[:3, :3] for _, P in now)]).reshape(-1, 3, 3),
            self._params.bound,
        )

    def observe(self, t_s: float, left: Leftovers) -> None:
        """Update the tracks with their contacts, begin one for each unclaimed contact, drop doubles."""
        n_known = len(self._known)
        seen = {row - n_known: sighting for sighting, row in left.claimed if row >= n_known}
        for row, sighting in seen.items():
            self._update(self._tracks[row], sighting)
        self._doubt_doubles(t_s, set(seen), left)
        self._tracks = [track for track in self._tracks if track.doubts < _DOUBTS]
        for sighting in left.unclaimed:
            self._tracks.append(self._begun(t_s, sighting))

    def _doubt_doubles(self, t_s: float, seen: set[int], left: Leftovers) -> None:
        """Count for each track how often it, or what is at its place, got the only contact (rule 3)."""
        now = [self._at(track, t_s) for track in self._tracks]
        others = _Objects(
            np.concatenate((left.points, np.array([x[:3] for x, _ in now]).reshape(-1, 3))),
            np.concatenate((left.covariances, np.array([P[:3, :3] for _, P in now]).reshape(-1, 3, 3))),
            np.concatenate((left.is_seen, [row in seen for row in range(len(now))])).astype(np.bool_),
        )
        for row, track in enumerate(self._tracks):
            is_seen = row in seen
            which = others.is_seen != is_seen
            which[len(left.points) + row :] = False
            if self._is_at_one(now[row], others, which):
                track.doubts += 1
            elif is_seen:
                track.doubts = 0

    def obstacles(self, t_s: float) -> Sensed:
        """Return the confirmed tracks that are not forgotten."""
        self._forget(t_s)
        return tuple([self._sensed(track, t_s) for track in self._tracks if track.is_confirmed])

    def _forget(self, t_s: float) -> None:
        p = self._params
        self._tracks = [
            track
            for track in self._tracks
            if t_s - track.seen_s <= (p.forget_s if track.is_confirmed else p.confirm_s)
        ]

    def _at(self, track: _Track, t_s: float) -> tuple[Matrix, Matrix]:
        dt_s = t_s - track.time_s
        Q = process_noise(dt_s, self._params.acceleration_psd)
        return predicted(track.x, track.P, transition_matrix(dt_s), Q)

    def _begun(self, t_s: float, sighting: Sighting) -> _Track:
        self._started += 1
        P = np.eye(6) * self._params.speed_sd_mps**2
        P[:3, :3] = sighting.covariance
        track = _Track(self._started, t_s, np.concatenate((sighting.point, np.zeros(3))), P)
        self._count(track, t_s)
        return track

    def _update(self, track: _Track, sighting: Sighting) -> None:
        x, P = self._at(track, sighting.time_s)
        track.x, track.P, _ = updated(x, P, sighting.point - x[:3], _H, sighting.covariance)
        track.time_s = sighting.time_s
        self._count(track, sighting.time_s)

    def _count(self, track: _Track, t_s: float) -> None:
        """Count a contact, and confirm the track if there were enough of them lately."""
        track.seen_s = t_s
        if not track.is_confirmed:
            track.first_s = [s for s in track.first_s if t_s - s <= self._params.confirm_s] + [t_s]
            track.is_confirmed = len(track.first_s) >= self._params.confirm_contacts

    def _is_at_one(self, state: tuple[Matrix, Matrix], others: _Objects, which: NDArray[np.bool_]) -> bool:
        """Return whether a track in this state is at the place of one of the objects `which` (a mask)."""
        if not which.any():
            return False
        x, P = state
        squared, likelihood = distances(
            x[None, :3], P[None, :3, :3], others.points[which], others.covariances[which]
        )
        return bool(((squared <= _SAME_PLACE) & (likelihood <= self._params.bound)).any())

    def _sensed(self, track: _Track, t_s: float) -> SensedObstacle:
        x, P = self._at(track, t_s)
        numbers: list[float] = x.tolist()
        return SensedObstacle(
            track.number,
            (numbers[0], numbers[1], numbers[2]),
            (numbers[3], numbers[4], numbers[5]),
            math.sqrt(float(np.linalg.eigvalsh(P[:3, :3])[-1])),
            t_s - track.seen_s,
            self._params.safety_distance_m,
        )
