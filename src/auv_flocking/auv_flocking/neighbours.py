"""
What a vehicle believes of its neighbours between packets: one extended Kalman filter each, thesis Eqs.
(5.29)-(5.35).

State: position (m) and velocity (m/s), NED; process: constant velocity with white acceleration of spectral
density q, discretised exactly.  A packet updates the filter at the packet's own time tag, however late it
came, and the estimate is then carried to now with the covariance that the wait costs.  filterpy runs predict
and update (Joseph form).

A packet older than the newest one of its sender is not used, and is counted: with one packet per cycle on
the air, packets of one sender cannot overtake each other, so this is a guard and not a filter for reordered
traffic.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from auv_core.geometry import Vec3
from auv_core.messages import SonarContact, VehicleState
from auv_core.params import param
from auv_flocking.report import Report

Matrix = NDArray[np.float64]

_CLOCK_SLACK_S = 1.0


def _on_every_axis(block: list[list[float]]) -> Matrix:
    """Return the (6, 6) matrix that does on every axis what the (2, 2) block does to position and rate."""
    return np.asarray(np.kron(block, np.eye(3)), dtype=np.float64)


_IDENTITY = np.eye(6)
_DRIFT = _on_every_axis([[0.0, 1.0], [0.0, 0.0]])
_POSITION = _on_every_axis([[1.0, 0.0], [0.0, 0.0]])
_COUPLING = _on_every_axis([[0.0, 1.0], [1.0, 0.0]])
_VELOCITY = _on_every_axis([[0.0, 0.0], [0.0, 1.0]])


@dataclass(frozen=True)
class NeighbourConfig:
    """Noise that the filter assumes, and how long silence is believed."""

    acceleration_psd: float = param(
        "spectral density of a neighbour's acceleration (m^2/s^3)", default=1e-3, above=0.0
    )
    position_std_m: float = param(
        "standard deviation of a reported position, per axis (m)", default=0.02, above=0.0
    )
    velocity_std_mps: float = param(
        "standard deviation of a reported velocity, per axis (m/s)", default=0.01, above=0.0
    )
    timeout_s: float = param("silence after which a neighbour no longer counts (s)", default=30.0, above=0.0)


@dataclass(frozen=True, slots=True)
class NeighbourEstimate:
    """
    A neighbour as believed at one instant.

    position (m), velocity (m/s), centre (m), flock_velocity (m/s): NED, in the frame of the own navigation;
    covariance (6, 6) of position relative to the own vehicle, and of velocity; age_s: time since the time tag
    `time_s` of its newest packet.  flock_stamp_s: when a leader made this flock velocity (-inf: never heard
    of one); sonar_age_s: time since the own sonar saw it (inf: never); navigation_sd_m: what the neighbour
    states of its own navigation, per axis; shared: what its consensus filter added to the packet.
    """

    address: int
    position: Vec3
    velocity: Vec3
    covariance: Matrix
    age_s: float
    centre: Vec3
    flock_velocity: Vec3
    flock_stamp_s: float = -math.inf
    sonar_age_s: float = math.inf
    navigation_sd_m: float = 0.0
    time_s: float = -math.inf
    shared: tuple[float, ...] = ()


def transition_matrix(dt_s: float) -> Matrix:
    """Return F (6, 6) of the constant-velocity model over `dt_s`."""
    return _IDENTITY + dt_s * _DRIFT


def process_noise(dt_s: float, acceleration_psd: float) -> Matrix:
    """
    Return Q (6, 6) of white acceleration over `dt_s`: q [[dt^3/3, dt^2/2], [dt^2/2, dt]] on every axis,
    exact.
    """
    q = acceleration_psd * dt_s
    return (q * dt_s * dt_s / 3.0) * _POSITION + (0.5 * q * dt_s) * _COUPLING + q * _VELOCITY


def kalman_filter() -> Any:
    """
    Return an unset filter for a state and a measurement of six components.

    filterpy is imported here, since that takes longer than all else that an agent imports: who hears nobody
    does not wait for it, and a node with neighbours calls this before its run begins.
    """
    from filterpy.kalman import ExtendedKalmanFilter

    return ExtendedKalmanFilter(dim_x=6, dim_z=6)


class _Track:
    """The filter of one neighbour, at the time tag of its newest packet."""

    def __init__(self, report: Report, config: NeighbourConfig) -> None:
        self._config = config
        self._filter = kalman_filter()
        self._filter.x = _measurement(report)
        self._filter.R = np.diag([config.position_std_m**2] * 3 + [config.velocity_std_mps**2] * 3)
        self._filter.P = self._filter.R.copy()
        self.report = report
        self._growth = self._covariance_growth()

    def update(self, report: Report) -> None:
        dt_s = report.time_s - self.report.time_s
        self._filter.F = transition_matrix(dt_s)
        self._filter.Q = process_noise(dt_s, self._config.acceleration_psd)
        self._filter.predict()
        self._filter.update(_measurement(report), HJacobian=lambda _x: np.eye(6), Hx=lambda x: x)
        self.report = report
        self._growth = self._covariance_growth()

    def _covariance_growth(self) -> tuple[Matrix, Matrix, Matrix, Matrix]:
        """
        Return the coefficients of F P F^T + Q as a cubic in the age: at every tick that is cheaper than the
        product.
        """
        covariance, psd = self._filter.P, self._config.acceleration_psd
        drifted = _DRIFT @ covariance
        return (
            covariance,
            drifted + drifted.T + psd * _VELOCITY,
            drifted @ _DRIFT.T + (0.5 * psd) * _COUPLING,
            (psd / 3.0) * _POSITION,
        )

    def estimate(self, t_s: float) -> NeighbourEstimate:
        report = self.report
        age_s = t_s - report.time_s
        x: list[float] = self._filter.x.tolist()
        constant, linear, square, cube = self._growth
        covariance = constant + age_s * (linear + age_s * (square + age_s * cube))
        return NeighbourEstimate(
            report.address,
            (x[0] + age_s * x[3], x[1] + age_s * x[4], x[2] + age_s * x[5]),
            (x[3], x[4], x[5]),
            covariance,
            age_s,
            (
                report.centre[0] + age_s * report.centre_rate[0],
                report.centre[1] + age_s * report.centre_rate[1],
                report.centre[2] + age_s * report.centre_rate[2],
            ),
            report.flock_velocity,
            getattr(report, "flock_stamp_s", -math.inf),
            math.inf,
            getattr(report, "position_sd_m", 0.0),
            report.time_s,
            getattr(report, "shared", ()),
        )


def _measurement(report: Report) -> Matrix:
    return np.array((*report.position, *report.velocity))


def is_plausible(report: Report, own_address: int, fleet_size: int, t_s: float) -> bool:
    """Tell whether a report comes from another vehicle of the fleet, and from this run and not its future."""
    other = report.address != own_address and report.address <= fleet_size
    return other and 0.0 <= report.time_s <= t_s + _CLOCK_SLACK_S


class NeighbourTable:
    """
    The filters of one vehicle. Fed with reports only, so that a recorded run can be estimated again without
    the simulator.
    """

    def __init__(self, config: NeighbourConfig) -> None:
        self._config = config
        self._tracks: dict[int, _Track] = {}
        self.outdated = 0

    @property
    def heard(self) -> int:
        """Number of neighbours heard at least once."""
        return len(self._tracks)

    def receive(self, report: Report) -> None:
        """Use one report; reports come in the order of their arrival."""
        track = self._tracks.get(report.address)
        if track is None:
            self._tracks[report.address] = _Track(report, self._config)
        elif report.time_s <= track.report.time_s:
            self.outdated += 1
        else:
            track.update(report)

    def observe(self, t_s: float, nav: VehicleState, contacts: Sequence[SonarContact]) -> None:
        """Use the sonar contacts of one tick, seen from the pose that the own navigation gives."""

    def estimates(self, t_s: float, nav: VehicleState | None = None) -> list[NeighbourEstimate]:
        """Return the neighbours heard within the time-out, carried to `t_s`, in the order of addresses."""
        return [
            track.estimate(t_s)
            for _, track in sorted(self._tracks.items())
            if t_s - track.report.time_s <= self._config.timeout_s
        ]
