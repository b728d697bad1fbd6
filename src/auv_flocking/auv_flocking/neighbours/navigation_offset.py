"""
Effect of two drifting navigations on a neighbour's position: four more states.

A packet contains the sender's position by the sender's navigation. A sonar contact is relative to the own
position by the own navigation. Both navigations have errors that change slowly and do not average out, so
they are not white measurement noise. With e_j and e_i (m, horizontal) the errors of the sender's and of the
own navigation, the state is

    p, v   position and velocity of the neighbour in the frame of the own navigation (true position + e_i)
    b      offset e_j - e_i (m; north, east)
    c      its rate (m/s; north, east), which for a log with a constant error is constant

and a packet measures p + b and v + c, the sonar p. Depths are measured by pressure and have no offset.
Without sonar b and p stay as uncertain as both navigations state. With sonar p is known, and packets then
determine b and c, which bridge the times without sonar contacts.

A position fix of a navigation changes e. The fix is assumed to be optimal (Kalman): the error after it is
rho times the error before it plus an independent part, rho = (variance after)/(variance before).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import inner
from auv_flocking.neighbours.motion import process_noise, transition_matrix

Matrix = NDArray[np.float64]

STATES = 10
B, C = slice(6, 8), slice(8, 10)
PACKET = np.eye(6, STATES)
PACKET[0, 6] = PACKET[1, 7] = PACKET[3, 8] = PACKET[4, 9] = 1.0

_LEVEL = np.eye(2)
_POSITION_DRIFT = np.zeros((STATES, STATES))
_VELOCITY_DRIFT = np.zeros((STATES, STATES))
for _axis in (0, 1):
    for _drift, _value, _offset in (
        (_POSITION_DRIFT, _axis, 6 + _axis),
        (_VELOCITY_DRIFT, 3 + _axis, 8 + _axis),
    ):
        _drift[_value, _value] = _drift[_offset, _offset] = 1.0
        _drift[_value, _offset] = _drift[_offset, _value] = -1.0
_RATE_MEMORY_S = 2000.0
_OUTGROWN_RATIO = 1.3


class Unaided(NamedTuple):
    """
    Knowledge of the offset without any sonar contact: variances of b, of b and c, of c, per axis (m^2,
    m^2/s, m^2/s^2), and the sender's last stated variance (m^2).
    """

    offset_m2: float
    mixed: float
    rate: float
    sender_m2: float

    def after(self, dt_s: float, rate_psd: float) -> Unaided:
        """Return the same after an interval."""
        offset_m2 = self.offset_m2 + dt_s * (2.0 * self.mixed + dt_s * (self.rate + rate_psd * dt_s / 3.0))
        mixed = self.mixed + dt_s * (self.rate + 0.5 * rate_psd * dt_s)
        return Unaided(offset_m2, mixed, self.rate + rate_psd * dt_s, self.sender_m2)


class Stated(NamedTuple):
    """Variances that the two navigations state (m^2, per horizontal axis)."""

    own_m2: float
    sender_m2: float

    @property
    def is_exact(self) -> bool:
        """Whether both state that they have no error."""
        return self.own_m2 == 0.0 and self.sender_m2 == 0.0

    @property
    def offset_m2(self) -> float:
        """Variance of the offset without any other knowledge."""
        return self.own_m2 + self.sender_m2

    def rate(self, drift_rate_mps: float) -> float:
        """
        Return the variance of the offset's rate if navigations with errors drift at this rate (m^2/s^2).
        """
        drifting = (self.own_m2 > 0.0) + (self.sender_m2 > 0.0)
        return drifting * drift_rate_mps * drift_rate_mps


def rate_psd(drift_rate_mps: float) -> float:
    """Return the spectral density of c's noise (m^2/s^3): a log's error slowly rotates with its vehicle."""
    return 2.0 * drift_rate_mps * drift_rate_mps / _RATE_MEMORY_S


@inner
def offset_transition(dt_s: float, memory_s: float = 0.0) -> Matrix:
    """Return F (10, 10) over an interval."""
    F = np.eye(STATES)
    F[:6, :6] = transition_matrix(dt_s, memory_s)
    F[6, 8] = F[7, 9] = dt_s
    return F


@inner
def offset_noise(dt_s: float, acceleration_psd: float, psd: float, memory_s: float = 0.0) -> Matrix:
    """Return the exact Q (10, 10) for white acceleration and a random walk of the rate."""
    Q = np.zeros((STATES, STATES))
    Q[:6, :6] = process_noise(dt_s, acceleration_psd, memory_s)
    q = psd * dt_s
    for b, c in ((6, 8), (7, 9)):
        Q[b, b] = q * dt_s * dt_s / 3.0
        Q[b, c] = Q[c, b] = 0.5 * q * dt_s
        Q[c, c] = q
    return Q


def first(z: Matrix, R: Matrix, stated: Stated, drift_rate_mps: float) -> tuple[Matrix, Matrix, Unaided]:
    """Return x (10,), P (10, 10) from one packet alone, with its numbers z (6,) and their noise R (6, 6)."""
    offset = np.diag([stated.offset_m2] * 2 + [stated.rate(drift_rate_mps)] * 2)
    P = np.zeros((STATES, STATES))
    H = PACKET[:, 6:]
    P[:6, :6] = R + H @ offset @ H.T
    P[:6, 6:] = -H @ offset
    P[6:, :6] = P[:6, 6:].T
    P[6:, 6:] = offset
    unaided = Unaided(stated.offset_m2, 0.0, stated.rate(drift_rate_mps), stated.sender_m2)
    return np.concatenate((z, np.zeros(4))), P, unaided


def widened(x: Matrix, P: Matrix) -> tuple[Matrix, Matrix, Unaided]:
    """Extend a state without offset (6,), (6, 6) by an offset that is exactly zero."""
    wide = np.zeros((STATES, STATES))
    wide[:6, :6] = P
    return np.concatenate((x, np.zeros(4))), wide, Unaided(0.0, 0.0, 0.0, 0.0)


def topped_up(P: Matrix, unaided: Unaided, stated: Stated, drift_rate_mps: float) -> tuple[Matrix, Unaided]:
    """
    Return P and the knowledge without sonar, increased if the navigations state larger variances.

    The stated variances are a lower bound: a vehicle that drifts faster than `drift_rate_mps` states so, and
    this is used. An increase of the offset is a decrease of the position, for packets give their sum: own
    drift moves the frame of the position, and a drifting sender reports a velocity with which the position
    was extrapolated wrongly.
    """
    more_m2 = stated.offset_m2 - unaided.offset_m2
    if stated.offset_m2 <= _OUTGROWN_RATIO * unaided.offset_m2:
        more_m2 = 0.0
    more_rate = max(stated.rate(drift_rate_mps) - unaided.rate, 0.0)
    if more_m2 > 0.0 or more_rate > 0.0:
        P = P + more_m2 * _POSITION_DRIFT + more_rate * _VELOCITY_DRIFT
    return P, unaided._replace(
        offset_m2=unaided.offset_m2 + more_m2,
        rate=unaided.rate + more_rate,
        sender_m2=stated.sender_m2,
    )


def after_sender_fix(
    x: Matrix, P: Matrix, unaided: Unaided, own_m2: float, sender_m2: float
) -> tuple[Matrix, Matrix, Unaided]:
    """
    Return the state after a fix of the sender's navigation, which this vehicle does not observe.

    The own error in the offset stays, and the part rho of the sender's error stays:
    b' = (k + rho (1 - k)) b + noise, k = own variance / both before the fix.
    """
    before_m2 = unaided.sender_m2
    k = own_m2 / (own_m2 + before_m2)
    rho = sender_m2 / before_m2
    keep = k + rho * (1.0 - k)
    fresh_m2 = (1.0 - rho) * ((1.0 - rho) * k * before_m2 + sender_m2)
    x, P = x.copy(), P.copy()
    x[B] *= keep
    P[B] *= keep
    P[:, B] *= keep
    P[B, B] += fresh_m2 * _LEVEL
    return (
        x,
        P,
        Unaided(keep * keep * unaided.offset_m2 + fresh_m2, keep * unaided.mixed, unaided.rate, sender_m2),
    )


@dataclass(frozen=True, slots=True)
class OwnFix:
    """
    A fix of the own navigation: time (s), jump of its position (m; north, east), and the variances that it
    stated before and after it (m^2, per horizontal axis).
    """

    time_s: float
    jump: tuple[float, float]
    before_m2: float
    after_m2: float

    def tells(self, sender_m2: float) -> tuple[Matrix, Matrix, Matrix]:
        """
        Return z (2,), H (2, 10), R (2, 2): the jump as a measurement of the offset before it.

        The own error before the fix was rho times itself minus the jump, so the jump measures the part of
        the offset that is the own error.
        """
        k = self.before_m2 / (self.before_m2 + sender_m2)
        gone = 1.0 - self.after_m2 / self.before_m2
        H = np.zeros((2, STATES))
        H[:, B] = -gone * k * _LEVEL
        R = gone * (gone * k * sender_m2 + self.after_m2) * _LEVEL
        return -np.array(self.jump), H, R

    def shifted(self, x: Matrix, unaided: Unaided) -> tuple[Matrix, Unaided]:
        """
        Return the state (10,) in the new frame: the neighbour's position relative to the own vehicle is
        unchanged.
        """
        x = x.copy()
        x[:2] += self.jump
        x[B] -= self.jump
        gone = 1.0 - self.after_m2 / self.before_m2
        offset_m2 = max(unaided.offset_m2 - gone * self.before_m2, self.after_m2 + unaided.sender_m2)
        k = self.before_m2 / (self.before_m2 + unaided.sender_m2)
        return x, unaided._replace(offset_m2=offset_m2, mixed=(1.0 - gone * k) * unaided.mixed)
