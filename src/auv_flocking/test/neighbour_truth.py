"""Truth that follows the neighbour filter's own model, and what one vehicle is told of it."""

from dataclasses import dataclass

import numpy as np

from auv_core.messages import VehicleState
from auv_flocking.neighbour_motion import process_noise, transition_matrix
from auv_flocking.report import Report
from auv_flocking.sonar_contact import contact_of

TICK_S = 0.1
LEVEL = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Setting:
    """What is measured of a neighbour, how well, and how the navigations err."""

    packets_every_s: float = 2.0
    lateness_s: tuple[float, float] = (0.3, 1.5)
    loss_prob: float = 0.0
    sonar_every_s: float = 0.0
    range_sd_m: float = 0.1
    angle_sd_rad: float = 0.0174533
    detection_prob: float = 0.9
    own_rate_mps: float = 0.0
    sender_rate_mps: float = 0.0
    own_fixes_s: tuple[float, ...] = ()
    sender_fixes_s: tuple[float, ...] = ()
    fix_sd_m: float = 0.3


class Navigation:
    """An error that grows at a constant random rate, until a fix makes the best of it."""

    def __init__(self, rng, rate_mps, fixes_s, fix_sd_m):
        self._rng, self._fixes_s, self._fix_sd_m = rng, fixes_s, fix_sd_m
        self.rate = rate_mps * rng.standard_normal(2)
        self._rate_mps = rate_mps
        self.error = np.zeros(2)
        self.P = np.diag([0.0, rate_mps**2])  # of error and rate, per axis

    def step(self, tick):
        """Let one tick pass."""
        self.error = self.error + TICK_S * self.rate
        F = np.array([[1.0, TICK_S], [0.0, 1.0]])
        self.P = F @ self.P @ F.T
        if any(round(fix_s / TICK_S) == tick for fix_s in self._fixes_s):
            K = self.P[0, 0] / (self.P[0, 0] + self._fix_sd_m**2)
            measured = self.error + self._fix_sd_m * self._rng.standard_normal(2)
            self.error = self.error - K * measured
            # The rate is not corrected (Schmidt): Joseph's form with the gain (K, 0).
            A = np.array([[1.0 - K, 0.0], [0.0, 1.0]])
            self.P = A @ self.P @ A.T + np.diag([(K * self._fix_sd_m) ** 2, 0.0])

    @property
    def sd_m(self):
        """What it states."""
        return float(np.sqrt(self.P[0, 0]))


def fly(setting, config, seed, duration_s, start=(4.0, 3.0, 1.0, 0.0, 0.0, 0.0)):
    """
    Yield per tick: time (s), own navigation, packets that arrive, contacts, and the neighbour's true state.

    The true state (6,) is in the frame of the own navigation.
    """
    rng = np.random.default_rng(seed)
    state, own_position, own_velocity = np.array(start), np.zeros(3), np.array([0.05, -0.03, 0.0])
    own = Navigation(rng, setting.own_rate_mps, setting.own_fixes_s, setting.fix_sd_m)
    sender = Navigation(rng, setting.sender_rate_mps, setting.sender_fixes_s, setting.fix_sd_m)
    F, L = transition_matrix(TICK_S), np.linalg.cholesky(process_noise(TICK_S, config.acceleration_psd))
    noise = np.array([config.position_std_m] * 3 + [config.velocity_std_mps] * 3)
    on_their_way = []
    for tick in range(round(duration_s / TICK_S)):
        t_s = tick * TICK_S
        if tick:
            state = F @ state + L @ rng.standard_normal(6)
            own_position = own_position + TICK_S * own_velocity
            own.step(tick)
            sender.step(tick)
        drift = np.array([*sender.error, 0.0, *sender.rate, 0.0])
        if tick % round(setting.packets_every_s / TICK_S) == 0 and rng.random() >= setting.loss_prob:
            z = tuple((state + drift + noise * rng.standard_normal(6)).tolist())
            report = Report(
                2, tick, t_s, z[:3], z[3:], (0.0,) * 3, (0.0,) * 3, (0.0,) * 3, position_sd_m=sender.sd_m
            )
            on_their_way.append((t_s + rng.uniform(*setting.lateness_s), report))
        arrived = [report for due_s, report in on_their_way if due_s <= t_s]
        on_their_way = [item for item in on_their_way if item[0] > t_s]
        shift = np.array([*own.error, 0.0, *own.rate, 0.0])
        believed = own_position + shift[:3]
        nav = VehicleState(
            tick,
            tuple(believed.tolist()),
            LEVEL,
            (*(own_velocity + shift[3:]).tolist(), 0.0, 0.0, 0.0),
            position_sd_m=own.sd_m,
        )
        yield t_s, nav, arrived, _contacts(setting, rng, tick, state[:3] - own_position), state + shift


def _contacts(setting, rng, tick, relative):
    if not setting.sonar_every_s or tick % round(setting.sonar_every_s / TICK_S):
        return ()
    if rng.random() >= setting.detection_prob:
        return ()
    contact = contact_of(tuple(relative.tolist()))
    off = rng.standard_normal(3) * (setting.range_sd_m, setting.angle_sd_rad, setting.angle_sd_rad)
    return (
        type(contact)(contact.range_m + off[0], contact.bearing_rad + off[1], contact.elevation_rad + off[2]),
    )
