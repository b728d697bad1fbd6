"""
A neighbour that moves exactly as the filter assumes, and the measurements of it.

It serves to test the filter's consistency: white acceleration, packets that are late or lost, sonar
contacts, and two navigations that drift at constant random rates and get fixes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from auv_core.geometry import Vec3
from auv_core.messages import SonarContact, VehicleState
from auv_flocking.neighbours.filter import NeighbourConfig
from auv_flocking.neighbours.motion import process_noise, transition_matrix
from auv_flocking.neighbours.sonar_contact import contact_of
from auv_flocking.report import Report

Matrix = NDArray[np.float64]

ADDRESS = 2
TICK_S = 0.1
_OWN_VELOCITY = np.array((0.05, -0.03, 0.0))
_START = np.array((4.0, 3.0, 1.0, 0.0, 0.0, 0.0))
_LEVEL = (1.0, 0.0, 0.0, 0.0)
_ZERO: Vec3 = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Setting:
    """
    Measurements of the neighbour, and errors of the two navigations.

    Times in s; `sonar_every_s` 0 means no sonar; the rates are standard deviations per horizontal axis (m/s).
    """

    packets_every_s: float = 1.0
    lateness_s: tuple[float, float] = (0.3, 1.5)
    loss_prob: float = 0.0
    sonar_every_s: float = 0.0
    detection_prob: float = 0.9
    own_rate_mps: float = 0.0
    sender_rate_mps: float = 0.0
    own_fixes_s: tuple[float, ...] = ()
    sender_fixes_s: tuple[float, ...] = ()
    fix_sd_m: float = 0.1


@dataclass(frozen=True)
class Instant:
    """
    One tick: time (s), own navigation, arriving measurements, and the truth.

    `truth` (6,) is the neighbour's position (m) and velocity (m/s), NED, in the frame of the own navigation.
    """

    t_s: float
    nav: VehicleState
    reports: tuple[Report, ...]
    contacts: tuple[SonarContact, ...]
    truth: Matrix


class _Drift:
    """A horizontal error that grows at a constant random rate until an optimal fix."""

    def __init__(
        self, rng: np.random.Generator, rate_mps: float, fixes_s: tuple[float, ...], fix_sd_m: float
    ) -> None:
        self._rng, self._fix_sd_m = rng, fix_sd_m
        self._fix_ticks = {round(fix_s / TICK_S) for fix_s in fixes_s}
        self.rate = rate_mps * rng.standard_normal(2)
        self.error = np.zeros(2)
        self._P = np.diag([0.0, rate_mps**2])  # of error and rate, per axis

    def step(self, tick: int) -> None:
        """
        Advance one tick; a fix corrects the error but not the rate, with the optimal gain for the error.
        """
        self.error = self.error + TICK_S * self.rate
        F = np.array([[1.0, TICK_S], [0.0, 1.0]])
        self._P = F @ self._P @ F.T
        if tick in self._fix_ticks:
            gain = self._P[0, 0] / (self._P[0, 0] + self._fix_sd_m**2)
            self.error = self.error - gain * (self.error + self._fix_sd_m * self._rng.standard_normal(2))
            A = np.diag([1.0 - gain, 1.0])
            self._P = A @ self._P @ A.T + np.diag([(gain * self._fix_sd_m) ** 2, 0.0])

    @property
    def shift(self) -> Matrix:
        """Effect of the error on position and velocity (6,)."""
        return np.array((*self.error, 0.0, *self.rate, 0.0))

    @property
    def sd_m(self) -> float:
        """Standard deviation that the navigation states (m, per axis)."""
        return float(np.sqrt(self._P[0, 0]))


def fly(
    setting: Setting, config: NeighbourConfig, rng: np.random.Generator, duration_s: float
) -> Iterator[Instant]:
    """Yield the ticks of one run; `config` sets the neighbour's motion and the noise."""
    state, position = _START.copy(), np.zeros(3)
    own = _Drift(rng, setting.own_rate_mps, setting.own_fixes_s, setting.fix_sd_m)
    sender = _Drift(rng, setting.sender_rate_mps, setting.sender_fixes_s, setting.fix_sd_m)
    F = transition_matrix(TICK_S, config.velocity_memory_s)
    root = np.linalg.cholesky(process_noise(TICK_S, config.acceleration_psd, config.velocity_memory_s))
    noise = np.array([config.position_std_m] * 3 + [config.velocity_std_mps] * 3)
    on_their_way: list[tuple[float, Report]] = []
    for tick in range(round(duration_s / TICK_S)):
        t_s = tick * TICK_S
        if tick:
            state = F @ state + root @ rng.standard_normal(6)
            position = position + TICK_S * _OWN_VELOCITY
            own.step(tick)
            sender.step(tick)
        if tick % round(setting.packets_every_s / TICK_S) == 0 and rng.random() >= setting.loss_prob:
            z = state + sender.shift + noise * rng.standard_normal(6)
            due_s = t_s + rng.uniform(*setting.lateness_s)
            on_their_way.append((due_s, _report(tick, z, sender.sd_m)))
        arrived = tuple(report for due_s, report in on_their_way if due_s <= t_s)
        on_their_way = [item for item in on_their_way if item[0] > t_s]
        contacts = _contacts(setting, config, rng, tick, state[:3] - position)
        nav = _navigation(tick, position, own)
        yield Instant(t_s, nav, arrived, contacts, state + own.shift)


def _report(tick: int, z: Matrix, sd_m: float) -> Report:
    (x, y, down), (u, v, w) = z.reshape(2, 3).tolist()
    return Report(ADDRESS, tick * TICK_S, (x, y, down), (u, v, w), _ZERO, _ZERO, position_sd_m=sd_m)


def _navigation(tick: int, position: Matrix, own: _Drift) -> VehicleState:
    north, east, down = (position + own.shift[:3]).tolist()
    u, v, w = (_OWN_VELOCITY + own.shift[3:]).tolist()
    nu = (u, v, w, 0.0, 0.0, 0.0)
    return VehicleState(tick, (north, east, down), _LEVEL, nu, position_sd_m=own.sd_m)


def _contacts(
    setting: Setting, config: NeighbourConfig, rng: np.random.Generator, tick: int, relative: Matrix
) -> tuple[SonarContact, ...]:
    if not setting.sonar_every_s or tick % round(setting.sonar_every_s / TICK_S):
        return ()
    if rng.random() >= setting.detection_prob:
        return ()
    x, y, z = relative.tolist()
    contact = contact_of((x, y, z))
    a, b, c = rng.standard_normal(3).tolist()
    sd_rad = config.sonar_angle_std_rad
    return (
        SonarContact(
            contact.range_m + config.sonar_range_std_m * a,
            contact.bearing_rad + sd_rad * b,
            contact.elevation_rad + sd_rad * c,
        ),
    )
