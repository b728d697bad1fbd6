"""
Single integrator: the velocity follows the command at once, as in the thesis's simulations of chapters 5 and
6.

Deviation: a current is refused, since the velocity command is over ground and the vehicle would not drift.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.geometry import Vec3, heading_from_quaternion, ned_to_body, quaternion_from_heading
from auv_core.integrate import State
from auv_core.messages import Numbers
from auv_core.models import Handling, VehicleModel, hovering
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """A point with a hull around it."""

    hull_radius_m: float = param("radius of the sphere around the hull (m)", default=0.3, above=0.0)


class Model(VehicleModel):
    """A vehicle that takes an NED velocity (m/s) and a yaw rate (rad/s)."""

    command = "velocity"

    def __init__(self, params: Params) -> None:
        self.params = params

    @property
    def handling(self) -> Handling:
        """It hovers."""
        return hovering(self.params.hull_radius_m)

    @property
    def top_speed_mps(self) -> float:
        """Infinite: a single integrator has no actuators."""
        return math.inf

    def speed_held_mps(self, max_force_n: float) -> float:
        """Return infinity: no force is needed."""
        return math.inf

    def initial_state(self, position: Vec3, heading_rad: float, speed_mps: float = 0.0) -> State:
        """Return the state of a vehicle that runs ahead at a speed over ground (m/s)."""
        return (*position, *quaternion_from_heading(heading_rad), speed_mps, 0.0, 0.0, 0.0, 0.0, 0.0)

    def limited_command(self, command: Numbers) -> Numbers:
        """Return `command` itself: a single integrator has no actuators."""
        return command

    def step(self, state: State, command: Numbers, current: Vec3, dt_s: float, steps: int = 1) -> State:
        """
        Return the state after `steps` steps of `dt_s`: exact for a held command [NED velocity, 0, 0, yaw
        rate].
        """
        for _ in range(steps):
            state = self._stepped(state, command, dt_s)
        return state

    def _stepped(self, state: State, command: Numbers, dt_s: float) -> State:
        velocity: Vec3 = (command[0], command[1], command[2])
        x, y, z = (state[axis] + dt_s * velocity[axis] for axis in range(3))
        heading_rad = heading_from_quaternion((state[3], state[4], state[5], state[6])) + dt_s * command[5]
        attitude = quaternion_from_heading(math.remainder(heading_rad, 2.0 * math.pi))
        return (x, y, z, *attitude, *ned_to_body(attitude, velocity), 0.0, 0.0, command[5])
