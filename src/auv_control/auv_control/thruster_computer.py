"""
The part of a vehicle's computer that turns the wrench of a controller into demands to thrusters.

An allocator chooses the forces. They follow their demands with a lag T, so the demands lead: with the force f
at the start of a control period h,

    f_c = (f_a - e f) / (1 - e),    e = exp(-h / T),

clipped at the limits, so that the force f_a that the allocator chose is there at the end of the period. f is
not measured; it follows from the demands before. Without this lead a lag of 0.2 s shakes a flock of ODINs,
whose law and velocity loop have their crossover at 2 rad/s (docs/explanation/thrusters.md).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from auv_control.allocation import Forces, make_allocator
from auv_core.compiled import entry, fastest
from auv_core.messages import ThrusterCommand, Vec6
from auv_core.params import Section
from auv_core.thrusters import ThrusterFault, Thrusters

Floats = NDArray[np.float64]


@entry("void(float64[:, ::1], float64[:, ::1], float64)", allocates=False)
def put_demands(rows: Floats, limits: Floats, kept: float) -> None:
    """
    Replace goals by the demands that lead to them, and the forces by those at the end of the period.

    Parameters
    ----------
    rows : (2, n) array
        Goals and forces at the start of the period (N); overwritten by demands and forces at its end.
    limits : (2, n) array
        Lowest and highest demands (N).
    kept : float
        e, the part of a force's distance to its demand that is left after the period.

    """
    for i in range(rows.shape[1]):
        force = rows[1, i]
        demand = min(max((rows[0, i] - kept * force) / (1.0 - kept), limits[0, i]), limits[1, i])
        rows[0, i] = demand
        rows[1, i] = demand + kept * (force - demand)


class ThrusterComputer:
    """
    An allocator of the intact vehicle, and one of the vehicle as it is known to be after a fault.

    Parameters
    ----------
    allocation : Section
        Kind and parameters of the allocator.
    thrusters : Thrusters
        Of the vehicle, at least one.
    fault : ThrusterFault
        Fault of a thruster, and when it is known.
    period_s : float
        Control period (s).

    """

    def __init__(
        self, allocation: Section, thrusters: Thrusters, fault: ThrusterFault, period_s: float
    ) -> None:
        self._fault = fault
        self._intact = make_allocator(allocation, thrusters)
        lost = (fault.thruster,) if fault.thruster else ()
        self._damaged = make_allocator(allocation, thrusters, lost)
        self._limits = np.array([thrusters.lowest_n, thrusters.highest_n])
        self._damaged_limits = self._limits.copy()
        self._damaged_limits[:, [number - 1 for number in lost]] = 0.0
        lag_s = thrusters.lag_s if thrusters.assumed_lag_s is None else thrusters.assumed_lag_s
        self._kept = math.exp(-period_s / lag_s) if lag_s > 0.0 else 0.0
        self._rows = np.zeros((2, thrusters.count))
        self._put = fastest(put_demands)

    def command(self, t_s: float, tau: Vec6) -> ThrusterCommand:
        """Return the demands for a wrench (N, N m; body), with the faults known at the time `t_s` (s)."""
        if self._fault.is_known(t_s):
            return self._asked(self._damaged.forces_n(tau), self._damaged_limits)
        return self._asked(self._intact.forces_n(tau), self._limits)

    def rest(self) -> ThrusterCommand:
        """Return demands of no force."""
        return self._asked((0.0,) * self._rows.shape[1], np.zeros_like(self._limits))

    def _asked(self, goals_n: Forces, limits: Floats) -> ThrusterCommand:
        """Return the demands after which the forces are at these goals (N) at the end of the period."""
        self._rows[0] = goals_n
        self._put(self._rows, limits, self._kept)
        return ThrusterCommand(tuple(self._rows[0].tolist()))
