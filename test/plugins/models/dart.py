"""
A vehicle that cannot stop, without forces: its speed follows the propeller, its turn the rudder and its pitch
the stern planes, each with a time constant.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.geometry import body_to_ned, ned_to_body
from auv_core.models import HULL, Actuator, Handling, VehicleModel
from auv_core.params import param

_ACTUATORS = (Actuator("rudder", "rad"), Actuator("stern_plane", "rad"), Actuator("propeller", "rpm"))


@dataclass(frozen=True)
class Params:
    """Size, limits and gains."""

    length_m: float = param("length of the hull (m)", default=2.0, above=0.0)
    diameter_m: float = param("diameter of the hull (m)", default=0.2, above=0.0)
    most_rpm: float = param("largest speed of the propeller (rpm)", default=1500.0, above=0.0)
    rpm_per_mps: float = param("speed of the propeller per speed (rpm/(m/s))", default=600.0, above=0.0)
    fin_max_rad: float = param("largest angle of a fin (rad)", default=0.26, above=0.0)
    turn_per_m: float = param("curvature per angle of the rudder (1/(m rad))", default=0.2, above=0.0)
    dive_per_m: float = param("pitch rate per angle and speed (1/(m rad))", default=0.3, above=0.0)
    righting_ps2: float = param("pitch acceleration per pitch (1/s^2)", default=0.75, above=0.0)


class Model(VehicleModel):
    """It runs where it points."""

    command = "fins"
    actuators = _ACTUATORS

    def __init__(self, params):
        self.params = params

    @property
    def handling(self):
        """It cannot stop."""
        return Handling(
            can_stop=False,
            least_speed_mps=0.5,
            hull_length_m=self.params.length_m,
            hull_diameter_m=self.params.diameter_m,
            near_m=6.0,
        )

    @property
    def top_speed_mps(self):
        """Speed at the largest speed of the propeller (m/s)."""
        return self.params.most_rpm / self.params.rpm_per_mps

    def speed_held_mps(self, max_force_n):
        """Return the top speed: no force is limited."""
        return self.top_speed_mps

    def turn_radius_m(self, speed_mps):
        """Return the radius with full rudder (m), the same at every speed."""
        return 1.0 / (self.params.turn_per_m * self.params.fin_max_rad)

    def initial_state(self, position, heading_rad, speed_mps=0.0):
        """Return the state of a level vehicle that runs ahead."""
        attitude = _attitude(heading_rad, 0.0)
        rpm = self.params.rpm_per_mps * speed_mps
        return (*position, *attitude, speed_mps, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, rpm)

    def resting_command(self):
        """Return fins amidships and a propeller at rest."""
        return (0.0, 0.0, 0.0)

    def limited_command(self, command):
        """Return angles (rad) and speed (rpm) within their limits."""
        most_rad, most_rpm = self.params.fin_max_rad, self.params.most_rpm
        rudder_rad, plane_rad = (min(max(fin, -most_rad), most_rad) for fin in command[:2])
        return (rudder_rad, plane_rad, min(max(command[2], 0.0), most_rpm))

    def step(self, state, command, current, dt_s, steps=1):
        """Return the state after Euler steps."""
        for _ in range(steps):
            state = self._stepped(state, command, current, dt_s)
        return state

    def _stepped(self, state, command, current, dt_s):
        p = self.params
        position, attitude = state[:3], state[3:7]
        speed_mps = state[7] - ned_to_body(attitude, current)[0]
        pitch_rate, yaw_rate = state[11], state[12]
        rudder_rad, plane_rad, rpm = state[HULL:]
        w, x, y, z = attitude
        heading_rad = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        pitch_rad = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - x * z))))
        speed_mps += dt_s * (rpm / p.rpm_per_mps - speed_mps) / 5.0
        yaw_rate += dt_s * (p.turn_per_m * speed_mps * rudder_rad - yaw_rate)
        pitch_rate -= dt_s * (p.righting_ps2 * pitch_rad + 1.4 * pitch_rate)
        pitch_rate -= dt_s * p.dive_per_m * speed_mps * plane_rad
        attitude = _attitude(heading_rad + dt_s * yaw_rate, pitch_rad + dt_s * pitch_rate)
        over_ground = tuple(
            a + b for a, b in zip((speed_mps, 0.0, 0.0), ned_to_body(attitude, current), strict=True)
        )
        moved = body_to_ned(attitude, over_ground)
        position = tuple(a + dt_s * b for a, b in zip(position, moved, strict=True))
        outputs = (
            out + min(dt_s, 1.0) * (asked - out) for out, asked in zip(state[HULL:], command, strict=True)
        )
        return (*position, *attitude, *over_ground, 0.0, pitch_rate, yaw_rate, *outputs)


def _attitude(heading_rad, pitch_rad):
    """Return the quaternion of a hull without roll."""
    ch, sh = math.cos(0.5 * heading_rad), math.sin(0.5 * heading_rad)
    cp, sp = math.cos(0.5 * pitch_rad), math.sin(0.5 * pitch_rad)
    return (ch * cp, -sh * sp, ch * sp, sh * cp)
