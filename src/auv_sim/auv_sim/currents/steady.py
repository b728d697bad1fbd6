"""A current that is the same everywhere and at all times."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.geometry import Vec3
from auv_sim.currents import WaterCurrent


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


class Current(WaterCurrent):
    """The mean."""

    def __init__(self, params: Params, mean_ned_mps: Vec3, seed: int, address: int, period_s: float) -> None:
        del params, seed, address, period_s
        self._mean_mps = mean_ned_mps
        self.varies_by_mps = 0.0

    def at(self, tick: int) -> Vec3:
        """Return the mean (m/s; NED)."""
        del tick
        return self._mean_mps
