"""An obstacle that moves on a straight line with a constant velocity."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.geometry import Vec3
from auv_core.params import param
from auv_sim.obstacles import ObstacleMotion


@dataclass(frozen=True)
class Params:
    """A velocity over ground."""

    velocity_ned_mps: Vec3 = param(
        "velocity over ground (m/s; NED)", default=(0.1, 0.0, 0.0), minimum=-10.0, maximum=10.0
    )


class Motion(ObstacleMotion):
    """The offset v t."""

    def __init__(self, params: Params) -> None:
        self._velocity_mps = params.velocity_ned_mps

    def offset(self, t_s: float) -> Vec3:
        """Return v t (m; NED)."""
        north, east, down = self._velocity_mps
        return (north * t_s, east * t_s, down * t_s)
