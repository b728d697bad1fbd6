"""
The extended Kalman filter of a neighbour, thesis Eqs. (5.29)-(5.35), as functions from one estimate to the
next.

If both navigations state that they have no error, the state is position and velocity (m, m/s; NED);
otherwise the four states of `navigation_offset` are added. An estimator predicts and updates. The spectral
density of the acceleration is fixed, or follows the neighbour's packets: one and a half times the mean square
change of the reported velocity per second, with a fading memory. It starts at its upper bound, for a vehicle
that is first heard may be about to set off. The filter has no state: an estimate is never changed, so
that a track can go back to an earlier one when a packet arrives late.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from auv_core.geometry import Vec3
from auv_core.params import Section, param
from auv_flocking.estimators import Motion, Updated, ekf, make_estimator
from auv_flocking.neighbours import navigation_offset as offset
from auv_flocking.neighbours.motion import Turning, later
from auv_flocking.neighbours.navigation_offset import OwnFix, Stated, Unaided
from auv_flocking.neighbours.sonar_contact import Sighting
from auv_flocking.report import Report
from auv_flocking.reports import ReportDecoder

Matrix = NDArray[np.float64]

ESTIMATORS = "auv_flocking.estimators"
EKF = Section("ekf", ekf.Params())

_FIX_RATIO = 0.95
_IDENTITY = np.eye(6)
_MOST_RATIO, _LEAST_RATIO = 10.0, 0.01
_PRIOR_S = 5.0
_JITTER_RATIO = 1.5
_SENSELESS = 60.0  # squared Mahalanobis distance that six numbers exceed once in 10^11


@dataclass(frozen=True)
class NeighbourConfig:
    """Estimator and noise of the filter, and how long an estimate outlives silence."""

    estimator: Section = param("arithmetic of the filter", default=EKF, plugins=ESTIMATORS)
    acceleration_psd: float = param(
        "spectral density of a neighbour's acceleration (m^2/s^3)", default=1e-3, above=0.0
    )
    acceleration_memory_s: float = param(
        "time over which that density adapts to a neighbour's changes of velocity, 0 for a fixed density (s)",
        default=0.0,
        minimum=0.0,
    )
    velocity_memory_s: float = param(
        "relaxation time of a neighbour's velocity to its flock's, 0 for never (s)",
        default=0.0,
        minimum=0.0,
    )
    position_std_m: float = param(
        "least standard deviation of a reported position, per axis, to which the scenario adds the "
        "white noise of the navigation (m)",
        default=0.006,
        above=0.0,
    )
    velocity_std_mps: float = param(
        "the same of a reported velocity (m/s)",
        default=0.0007,
        above=0.0,
    )
    timeout_s: float = param(
        "time without packets and sonar contacts after which a neighbour is dropped (s)",
        default=30.0,
        above=0.0,
    )
    drift_rate_mps: float = param(
        "constant velocity error, per horizontal axis, of a navigation that states an uncertainty (m/s)",
        default=0.0075,
        above=0.0,
        maximum=10.0,
    )
    sonar_range_std_m: float = param("standard deviation of a sonar range (m)", default=0.1, above=0.0)
    sonar_angle_std_rad: float = param(
        "standard deviation of a sonar bearing and elevation (rad)", default=0.0174533, above=0.0
    )
    gate_prob: float = param(
        "probability that a true contact of a neighbour is accepted",
        default=0.999,
        minimum=0.5,
        maximum=0.999999,
    )
    rival_margin: float = param(
        "least difference of -2 ln likelihood to the next best pairing for a contact to count; 0: the best "
        "always counts",
        default=0.0,
        minimum=0.0,
    )


def with_rounding(config: NeighbourConfig, decoder: ReportDecoder) -> NeighbourConfig:
    """
    Return the noise that a filter assumes: at least the rounding error of the report format, a step over the
    square root of twelve.
    """
    return replace(
        config,
        position_std_m=max(config.position_std_m, decoder.position_resolution_m / math.sqrt(12.0)),
        velocity_std_mps=max(config.velocity_std_mps, decoder.velocity_resolution_mps / math.sqrt(12.0)),
    )


class Unrest(NamedTuple):
    """
    Velocity changes of a neighbour, from its packets: time tag (s) and velocity (m/s; NED) of the newest
    one, and the fading sums of squared changes per axis (m^2/s^2) and of their durations (s).
    """

    time_s: float
    velocity: Vec3
    squares: float
    duration_s: float

    @classmethod
    def begun(cls, report: Report, psd: float) -> Unrest:
        """Return the state after the first packet: a density that counts like `_PRIOR_S` of packets."""
        return cls(report.time_s, report.velocity, psd * _PRIOR_S / _JITTER_RATIO, _PRIOR_S)

    @property
    def psd(self) -> float:
        """
        Spectral density of the acceleration that is assumed for these changes (m^2/s^3).

        A velocity that jitters by s about its mean changes by 2 s^2 from packet to packet, after any gap g.
        The position predicted over g is then wrong by s^2 g^2; white acceleration with the density of these
        changes, 2 s^2 / g, gives two thirds of it.
        """
        return _JITTER_RATIO * self.squares / self.duration_s

    def after(self, report: Report, memory_s: float) -> Unrest:
        """Return the same after one more packet."""
        gap_s = report.time_s - self.time_s
        kept = math.exp(-gap_s / memory_s)
        squares = kept * self.squares + math.dist(report.velocity, self.velocity) ** 2 / 3.0
        return Unrest(report.time_s, report.velocity, squares, kept * self.duration_s + gap_s)


class Belief(NamedTuple):
    """
    The estimate of a neighbour at one time.

    Attributes
    ----------
    time_s : float
        Time of the estimate (s).
    x : (6,) or (10,) array
        Position (m) and velocity (m/s), NED; then offset (m) and rate (m/s), north and east.
    P : (6, 6) or (10, 10) array
        Its covariance.
    psd : float
        Spectral density of its acceleration (m^2/s^3).
    flock : tuple of 4 float
        Velocity of the flock as the neighbour estimates it (m/s; NED), and its rate of turn (rad/s).
    unaided : Unaided or None
        Knowledge of the offset without sonar; None without an offset.
    unrest : Unrest or None
        Source of the density; None if it is fixed.
    innovation, precision : arrays
        Innovation of the last measurement, and the inverse of its covariance; None if there was none.

    """

    time_s: float
    x: Matrix
    P: Matrix
    psd: float
    flock: Turning
    unaided: Unaided | None = None
    unrest: Unrest | None = None
    innovation: Matrix | None = None
    precision: Matrix | None = None

    @property
    def nis(self) -> float:
        """Normalised innovation squared of the last measurement; 0 if there was none."""
        if self.innovation is None or self.precision is None:
            return 0.0
        return float(self.innovation @ self.precision @ self.innovation)


class NeighbourFilter:
    """The filter for all neighbours of one vehicle; it has no state."""

    def __init__(self, config: NeighbourConfig) -> None:
        self._config = config
        self._rate_psd = offset.rate_psd(config.drift_rate_mps)
        self._noise = np.diag([config.position_std_m**2] * 3 + [config.velocity_std_mps**2] * 3)
        self._estimator = make_estimator(config.estimator)

    def first(self, report: Report, stated: Stated) -> Belief:
        """Return the estimate after the first packet: its content."""
        z, psd, unrest = _numbers(report), self._config.acceleration_psd, None
        if self._config.acceleration_memory_s > 0.0:
            psd *= _MOST_RATIO
            unrest = Unrest.begun(report, psd)
        if stated.is_exact:
            return Belief(report.time_s, z, self._noise.copy(), psd, _flock_of(report), None, unrest)
        x, P, unaided = offset.first(z, self._noise, stated, self._config.drift_rate_mps)
        return Belief(report.time_s, x, P, psd, _flock_of(report), unaided, unrest)

    def after_packet(self, belief: Belief, report: Report, stated: Stated) -> Belief:
        """
        Return the estimate after a packet, at the packet's time tag.

        With an offset, a packet that contradicts the estimate restarts the estimate: either a contact of
        another vehicle was associated with this one, or a navigation had a larger error than it stated.
        """
        unrest, psd = self._unrest(belief, report)
        ahead = self._predicted(belief, report.time_s, psd, unrest)
        if ahead.unaided is None and stated.is_exact:
            innovation, H = _numbers(report) - ahead.x, _IDENTITY
        else:
            ahead = self._with_offset(ahead, stated)
            innovation, H = _numbers(report) - offset.PACKET @ ahead.x, offset.PACKET
        now = psd if unrest is None else self._bounded(unrest.psd)
        update = self._estimator.updated(ahead.x, ahead.P, innovation, H, self._noise)
        after = _after(ahead, update)._replace(psd=now, flock=_flock_of(report))
        if after.unaided is not None and after.nis > _SENSELESS:
            return self.first(report, stated)
        return after

    def after_sighting(self, belief: Belief, sighting: Sighting) -> Belief:
        """Return the estimate after a sonar contact, at its time."""
        ahead = self._predicted(belief, sighting.time_s, belief.psd, belief.unrest)
        return _after(ahead, self._estimator.seen(ahead.x, ahead.P, sighting))

    def after_own_fix(self, belief: Belief, fix: OwnFix) -> Belief:
        """Return the estimate after a fix of the own navigation, in the navigation's new frame."""
        ahead = self._predicted(belief, fix.time_s, belief.psd, belief.unrest)
        if ahead.unaided is None:
            ahead = self._with_offset(ahead, Stated(fix.before_m2, 0.0))
        assert ahead.unaided is not None
        z, H, R = fix.tells(ahead.unaided.sender_m2)
        after = _after(ahead, self._estimator.updated(ahead.x, ahead.P, z - H @ ahead.x, H, R))
        x, unaided = fix.shifted(after.x, ahead.unaided)
        return after._replace(x=x, unaided=unaided)

    def _unrest(self, belief: Belief, report: Report) -> tuple[Unrest | None, float]:
        """
        Return the velocity changes up to a new packet, and the density for the prediction up to it.

        This density is the larger of those before and after the packet.
        """
        if belief.unrest is None:
            return None, belief.psd
        unrest = belief.unrest.after(report, self._config.acceleration_memory_s)
        return unrest, max(belief.psd, self._bounded(unrest.psd))

    def _bounded(self, psd: float) -> float:
        """Return a density limited to two decades below and one decade above the configured one (m^2/s^3)."""
        usual = self._config.acceleration_psd
        return min(max(psd, _LEAST_RATIO * usual), _MOST_RATIO * usual)

    def _with_offset(self, belief: Belief, stated: Stated) -> Belief:
        """Return the estimate with an offset as uncertain as the navigations state at its time."""
        x, P, unaided = belief.x, belief.P, belief.unaided
        if unaided is None:
            x, P, unaided = offset.widened(x, P)
        if stated.sender_m2 < _FIX_RATIO * _FIX_RATIO * unaided.sender_m2:
            x, P, unaided = offset.after_sender_fix(x, P, unaided, stated.own_m2, stated.sender_m2)
        P, unaided = offset.topped_up(P, unaided, stated, self._config.drift_rate_mps)
        return belief._replace(x=x, P=P, unaided=unaided)

    def _predicted(self, belief: Belief, t_s: float, psd: float, unrest: Unrest | None) -> Belief:
        dt_s = t_s - belief.time_s
        memory_s, unaided = self._config.velocity_memory_s, belief.unaided
        motion = Motion(dt_s, psd, self._rate_psd, memory_s, belief.flock)
        x, P = self._estimator.predicted(belief.x, belief.P, motion)
        if unaided is not None:
            unaided = unaided.after(dt_s, self._rate_psd)
        return Belief(t_s, x, P, psd, later(belief.flock, dt_s), unaided, unrest)


def _after(ahead: Belief, update: Updated) -> Belief:
    x, P, innovation, precision = update
    return ahead._replace(x=x, P=P, innovation=innovation, precision=precision)


def _flock_of(report: Report) -> Turning:
    """Return the flock's velocity as the sender flies it at its time tag: none while it holds station."""
    if report.is_holding:
        return (0.0, 0.0, 0.0, 0.0)
    if math.isinf(report.flock_stamp_s) or math.isnan(report.flock_turn_rate_radps):
        return (*report.flock_velocity, 0.0)
    set_then = (*report.flock_velocity, report.flock_turn_rate_radps)
    return later(set_then, report.time_s - report.flock_stamp_s)


def _numbers(report: Report) -> Matrix:
    return np.array((*report.position, *report.velocity))
