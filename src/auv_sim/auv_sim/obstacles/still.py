"""An obstacle that stays where it is."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.geometry import Vec3
from auv_sim.obstacles import ObstacleMotion


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


class Motion(ObstacleMotion):
    """No motion."""

    def __init__(self, params: Params) -> None:
        del params

    def offset(self, t_s: float) -> Vec3:
        """Return zero (m; NED)."""
        del t_s
        return (0.0, 0.0, 0.0)
