"""Steps of heading and depth at one time, at a constant speed: the manoeuvre that tries the autopilots."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_control.courses import CourseLaw, Guided
from auv_control.guidance.autopilots import Setpoint
from auv_control.guidance.feasibility import Turning, allowed_speeds
from auv_core.geometry import Box
from auv_core.messages import VehicleState
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """Setpoints before and after the step."""

    step_at_s: float = param("time of the step (s)", default=10.0, minimum=0.0)
    heading_before_rad: float = param(
        "heading before it (rad, from north towards east)", default=0.0, minimum=-math.tau, maximum=math.tau
    )
    heading_after_rad: float = param(
        "heading after it (rad)", default=math.radians(30.0), minimum=-math.tau, maximum=math.tau
    )
    depth_before_m: float = param("depth before it (m; NED z)", default=10.0, minimum=0.0, maximum=1e5)
    depth_after_m: float = param("depth after it (m; NED z)", default=20.0, minimum=0.0, maximum=1e5)
    speed_mps: float = param("speed ahead over ground (m/s)", default=1.5, above=0.0, maximum=10.0)


class Course(CourseLaw):
    """The speed that is compared is that ahead, u: there is no path along which it could count."""

    def __init__(self, params: Params, period_s: float) -> None:
        p = self._params = params
        self._half_period_s = 0.5 * period_s
        self._before = Setpoint(p.heading_before_rad, 0.0, p.depth_before_m, p.speed_mps)
        self._after = Setpoint(p.heading_after_rad, 0.0, p.depth_after_m, p.speed_mps)

    def step(self, t_s: float, nav: VehicleState) -> Guided:
        """Return what the course asks at `t_s`; the step falls on the tick that is nearest to its time."""
        is_after = t_s > self._params.step_at_s - self._half_period_s
        return Guided(self._after if is_after else self._before, nav.nu[0])

    def check(self, vehicle: Turning, current_mps: float) -> None:
        """Raise ValueError unless the vehicle holds the speed in a current of any direction (m/s)."""
        low_mps = vehicle.handling.least_speed_mps + current_mps
        high_mps = vehicle.top_speed_mps - current_mps
        if not low_mps <= self._params.speed_mps <= high_mps:
            raise ValueError(
                f"speed_mps: {self._params.speed_mps!r} is not allowed; "
                f"allowed: {allowed_speeds(vehicle, current_mps)}"
            )

    def reach(self, duration_s: float) -> Box | None:
        """Return None: the track depends on the vehicle."""
        return None
