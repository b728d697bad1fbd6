"""
Estimators: the arithmetic of a neighbour filter, from one estimate to the next.

To add one, write one file with ``Params`` and ``Estimator(params)``, a `NeighbourEstimator`.  The file's name
is its ``kind``.

An estimator has no state: `auv_flocking.neighbours.filter` keeps estimates, the density of the acceleration
and what is known of drifts, and `auv_flocking.neighbours.track` the order of measurements.  The state x is
position and velocity (m, m/s; NED), (6,), or with the offset of two drifting navigations and its rate (m,
m/s; north and east), (10,); P is its covariance.  Inputs are never changed, and results share no memory with
them.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from auv_core.contracts import class_of, fulfilled
from auv_core.params import Section
from auv_flocking.neighbours.motion import Turning
from auv_flocking.neighbours.sonar_contact import Sighting

Matrix = NDArray[np.float64]


class Motion(NamedTuple):
    """
    How the state moves over an interval (`auv_flocking.neighbours.motion`).

    dt_s: its length (s); psd, rate_psd: spectral densities of the acceleration (m^2/s^3) and of the offset's
    rate (m^2/s^3); memory_s: relaxation time of the velocity to the flock's (s; 0: never); flock: the
    flock's velocity (m/s; NED) and its rate of turn (rad/s).
    """

    dt_s: float
    psd: float
    rate_psd: float
    memory_s: float
    flock: Turning


class Updated(NamedTuple):
    """x and P after a measurement, its innovation (m,), and the inverse of the innovation's covariance."""

    x: Matrix
    P: Matrix
    innovation: Matrix
    precision: Matrix


class NeighbourEstimator(Protocol):
    """Predicts and updates an estimate."""

    def predicted(self, x: Matrix, P: Matrix, motion: Motion) -> tuple[Matrix, Matrix]:
        """Return x and P after an interval; P grows by the noise of the motion."""

    def updated(self, x: Matrix, P: Matrix, innovation: Matrix, H: Matrix, R: Matrix) -> Updated:
        """
        Return the estimate after a linear measurement: a packet or a fix.

        `innovation` (m,) is z - H x, R (m, m) the covariance of the measurement's noise.
        """

    def seen(self, x: Matrix, P: Matrix, sighting: Sighting) -> Updated:
        """Return the estimate after a sonar contact, which is not linear in the state."""


def make_estimator(section: Section) -> NeighbourEstimator:
    """Return the estimator of a section."""
    made = class_of(__name__, section.kind, "Estimator")(section.params)
    estimator: NeighbourEstimator = fulfilled(made, NeighbourEstimator)
    return estimator


def linearised(x: Matrix, sighting: Sighting) -> tuple[Matrix, Matrix]:
    """Return innovation (3,) and H (3, n) of a contact, linearised at the point that it gives."""
    H = np.zeros((3, len(x)))
    H[:, :3] = sighting.jacobian
    return -(sighting.jacobian @ (x[:3] - sighting.point)), H
