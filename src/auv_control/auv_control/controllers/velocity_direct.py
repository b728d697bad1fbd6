"""Pass the velocity reference on, for kinematic vehicles, which follow it at once."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_control.controllers import VelocityController, VelocityReference
from auv_core.geometry import heading_from_quaternion
from auv_core.messages import VehicleState, VelocityCommand
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """One gain, for the heading."""

    heading_gain_ps: float = param("yaw rate per heading error (1/s)", default=1.0, minimum=0.0)


class Controller(VelocityController):
    """The unchanged velocity, and a yaw rate towards the heading."""

    command = "velocity"
    follows = "velocity"

    def __init__(self, params: Params, period_s: float) -> None:
        del period_s
        self._gain_ps = params.heading_gain_ps

    def step(self, nav: VehicleState, reference: VelocityReference) -> VelocityCommand:
        """Return the velocity command (NED m/s, rad/s)."""
        error = math.remainder(reference.heading_rad - heading_from_quaternion(nav.attitude), 2.0 * math.pi)
        return VelocityCommand(reference.velocity, self._gain_ps * error)
