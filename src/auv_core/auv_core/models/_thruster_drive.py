"""
Thrusters on the hull of `six_dof`: the force of each follows its demand with a lag.

    f_dot = (f_c - f) / T_f,    tau = T f

The demands f_c are held over a control period, so f is known exactly at every instant. During one step of the
hull its wrench is the mean of tau, so that the impulse is exact and RK4 needs no state more.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import entry, fastest, inlined
from auv_core.geometry import Vec3
from auv_core.integrate import State
from auv_core.messages import Numbers, Vec6
from auv_core.models import HULL, Actuator
from auv_core.models._hull_forces import Constants
from auv_core.models._rigid_body import stepped
from auv_core.thrusters import Thrusters, axis_maxima, delivered_n

Floats = NDArray[np.float64]


@entry("void(float64[:, ::1], TUPLE2, float64[::1])", allocates=False)
def put_delivered(limits: Floats, zones: tuple[float, float], demands: Floats) -> None:
    """
    Replace demands by the steady forces of the thrusters (N).

    Parameters
    ----------
    limits : (2, n) array
        Lowest and highest forces (N).
    zones : (2,) tuple
        Dead zone of the thrusters, and the one that their drivers compensate.
    demands : (n,) array
        Demands (N); overwritten.

    """
    for i in range(len(demands)):
        demands[i] = delivered_n(demands[i], limits[0, i], limits[1, i], zones[0], zones[1])


@inlined
def wrench(T: Floats, forces: Floats) -> Vec6:
    """Return the wrench (N, N m; body) of forces (n,) (N), for a configuration matrix (6, n)."""
    x, y, z, k, m, n = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(len(forces)):
        force = float(forces[i])
        x += float(T[0, i]) * force
        y += float(T[1, i]) * force
        z += float(T[2, i]) * force
        k += float(T[3, i]) * force
        m += float(T[4, i]) * force
        n += float(T[5, i]) * force
    return (x, y, z, k, m, n)


@entry("TUPLE13(TUPLE13, float64[:, ::1], float64[:, ::1], TUPLE2, TUPLE3, TUPLE21, float64, int64)")
def advance_driven(
    x: State,
    T: Floats,
    forces: Floats,
    lag: tuple[float, float],
    current: Vec3,
    numbers: tuple[float, ...],
    dt_s: float,
    steps: int,
) -> State:
    """
    Return the state of the hull after `steps` steps of `dt_s`.

    Parameters
    ----------
    x : (13,) tuple
        State of the hull.
    T : (6, n) array
        Configuration matrix.
    forces : (2, n) array
        Forces, which are overwritten by those at the end, and the forces to which they tend (N).
    lag : (2,) tuple
        Part of a force's distance to its end that is left after a step, and in the mean over it.
    current : (3,) tuple
        Velocity of the water (m/s; NED).
    numbers : (21,) tuple
        The hull's `Constants`.
    dt_s, steps
        Length (s) and number of steps.

    """
    c = Constants(*numbers)
    start, end = wrench(T, forces[0]), wrench(T, forces[1])
    left = 1.0
    for _ in range(steps):
        mean = left * lag[1]
        tau = (
            end[0] + mean * (start[0] - end[0]),
            end[1] + mean * (start[1] - end[1]),
            end[2] + mean * (start[2] - end[2]),
            end[3] + mean * (start[3] - end[3]),
            end[4] + mean * (start[4] - end[4]),
            end[5] + mean * (start[5] - end[5]),
        )
        x = stepped(x, tau, current, c, dt_s)
        left *= lag[0]
    for i in range(T.shape[1]):
        forces[0, i] = forces[1, i] + left * (forces[0, i] - forces[1, i])
    return x


class ThrusterDrive:
    """
    The thrusters of one hull.

    Attributes
    ----------
    actuators : tuple of Actuator
        Their names and unit.
    axis_limits : (6,) tuple
        Largest pure forces (N) and moments (N m) that they give in both senses of an axis.

    """

    def __init__(self, thrusters: Thrusters) -> None:
        self.actuators = tuple(Actuator(f"thruster_{k + 1}", "N") for k in range(thrusters.count))
        self._T = thrusters.matrix()
        self._limits = np.array([thrusters.lowest_n, thrusters.highest_n])
        self._lag_s = thrusters.lag_s
        assumed, true = thrusters.assumed_dead_zone, thrusters.dead_zone
        self._zones = (true, true if assumed is None else assumed)
        held = axis_maxima(self._T, self._limits[0], self._limits[1]).min(axis=1)
        self.axis_limits: Vec6 = tuple(held.tolist())
        self._advance, self._put_delivered = fastest(advance_driven), fastest(put_delivered)

    def delivered(self, demands: Numbers) -> Numbers:
        """Return the steady forces for the demands (N): within the limits, and less the dead zone."""
        forces = np.array(demands)
        self._put_delivered(self._limits, self._zones, forces)
        return tuple(forces.tolist())

    def advance(
        self, state: State, ends: Numbers, current: Vec3, numbers: tuple[float, ...], dt_s: float, steps: int
    ) -> State:
        """Return a state, which includes the forces, after steps in which they tend to `ends` (N)."""
        forces = np.array((state[HULL:], ends))
        share = dt_s / self._lag_s
        lag = (math.exp(-share), -math.expm1(-share) / share)
        hull = self._advance(state[:HULL], self._T, forces, lag, current, numbers, dt_s, steps)
        return (*hull, *forces[0].tolist())

    def wrench(self, state: State) -> Vec6:
        """Return the wrench (N, N m; body) of the forces in a state."""
        return wrench(self._T, np.array(state[HULL:]))

    def rates(self, state: State, ends: Numbers) -> Numbers:
        """Return the rates of the forces in a state (N/s)."""
        return tuple((end - force) / self._lag_s for end, force in zip(ends, state[HULL:], strict=True))
