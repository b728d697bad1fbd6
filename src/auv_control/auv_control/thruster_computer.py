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

from auv_control.allocation import Forces, make_allocator
from auv_core.messages import ThrusterCommand, Vec6
from auv_core.params import Section
from auv_core.thrusters import ThrusterFault, Thrusters


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
        self._limits = list(zip(thrusters.lowest_n.tolist(), thrusters.highest_n.tolist(), strict=True))
        lag_s = thrusters.lag_s if thrusters.assumed_lag_s is None else thrusters.assumed_lag_s
        self._kept = math.exp(-period_s / lag_s) if lag_s > 0.0 else 0.0
        self._forces_n: Forces = (0.0,) * thrusters.count

    def command(self, t_s: float, tau: Vec6) -> ThrusterCommand:
        """Return the demands for a wrench (N, N m; body), with the faults known at the time `t_s` (s)."""
        if not self._fault.is_known(t_s):
            return self._asked(self._led(self._intact.forces_n(tau)))
        demands = list(self._led(self._damaged.forces_n(tau)))
        demands[self._fault.thruster - 1] = 0.0
        return self._asked(tuple(demands))

    def rest(self) -> ThrusterCommand:
        """Return demands of no force."""
        return self._asked((0.0,) * len(self._forces_n))

    def _led(self, goals_n: Forces) -> Forces:
        """Return the demands (N) after which the forces are at these goals (N) at the end of the period."""
        kept = self._kept
        return tuple(
            min(max((goal - kept * force) / (1.0 - kept), lowest), highest)
            for goal, force, (lowest, highest) in zip(goals_n, self._forces_n, self._limits, strict=True)
        )

    def _asked(self, demands_n: Forces) -> ThrusterCommand:
        """Return the command with these demands (N), and remember the forces that they lead to."""
        kept = self._kept
        self._forces_n = tuple(
            demand + kept * (force - demand) for demand, force in zip(demands_n, self._forces_n, strict=True)
        )
        return ThrusterCommand(demands_n)
