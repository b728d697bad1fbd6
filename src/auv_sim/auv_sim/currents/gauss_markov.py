"""A current that varies at random about its mean, partly alike at all vehicles and partly not."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.geometry import Vec3
from auv_core.params import param
from auv_sim.currents import WaterCurrent
from auv_sim.streams import Purpose, generator

_BLOCK_TICKS = 64
_WHOLE_FLEET = 0
_SELDOM_SIGMAS = 3.0


@dataclass(frozen=True)
class Params:
    """How much and how fast it varies."""

    sd_ned_mps: Vec3 = param(
        "standard deviation about the mean (m/s; NED)", default=(0.05, 0.05, 0.0), minimum=0.0, maximum=5.0
    )
    memory_s: float = param("time in which the correlation falls to 1/e (s)", default=60.0, above=0.0)
    common_share: float = param(
        "part of the variance that is alike at all vehicles; the rest is each vehicle's own",
        default=0.5,
        minimum=0.0,
        maximum=1.0,
    )


class Current(WaterCurrent):
    """
    Mean plus stationary first-order Gauss-Markov processes, held over each control period.

    Per axis x' = -x / T + w, sampled without error at the ticks: with a = exp(-period / T),

        x_0 = n_0,    x_k = a x_(k-1) + sqrt(1 - a^2) n_k,    n_k standard normal.

    So the variance is 1 at every tick, and the correlation over a time t is exp(-t / T), whatever the period.
    One process belongs to the whole fleet, one to each vehicle. A vehicle has the mean plus
    sd (sqrt(c) x_fleet + sqrt(1 - c) x_own), so that two vehicles have the correlation c.

    Source: Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control (2011), section 8.3; here per
    axis, without limits, and stationary from the start.
    Deviation: the variation between vehicles does not depend on their distance, and the water's acceleration
    exerts no force.
    """

    def __init__(self, params: Params, mean_ned_mps: Vec3, seed: int, address: int, period_s: float) -> None:
        self._mean_mps = mean_ned_mps
        self._fleet = _Process(params.memory_s, seed, _WHOLE_FLEET, period_s)
        self._own = _Process(params.memory_s, seed, address, period_s)
        fleet, own = math.sqrt(params.common_share), math.sqrt(1.0 - params.common_share)
        self._scales = [(fleet * sd_mps, own * sd_mps) for sd_mps in params.sd_ned_mps]
        self.varies_by_mps = _SELDOM_SIGMAS * math.hypot(*params.sd_ned_mps)

    def at(self, tick: int) -> Vec3:
        """Return the velocity of the water (m/s; NED) in the control period that begins at `tick`."""
        fleet, own = self._fleet.at(tick), self._own.at(tick)
        north, east, down = (
            mean + scales[0] * x + scales[1] * y
            for mean, scales, x, y in zip(self._mean_mps, self._scales, fleet, own, strict=True)
        )
        return (north, east, down)


class _Process:
    """Three independent processes of variance 1, fixed by seed, owner and tick."""

    def __init__(self, memory_s: float, seed: int, owner: int, period_s: float) -> None:
        self._kept = math.exp(-period_s / memory_s)
        self._fresh = math.sqrt(-math.expm1(-2.0 * period_s / memory_s))
        self._seed = seed
        self._owner = owner
        self._block = -1
        self._normals: list[list[float]] = []
        self._tick = 0
        self._x = self._drawn(0)

    def at(self, tick: int) -> Vec3:
        """Return the processes at `tick`; an earlier one than before is reached from the start again."""
        if tick < self._tick:
            self._tick, self._x = 0, self._drawn(0)
        while self._tick < tick:
            self._tick += 1
            (x, y, z), (dx, dy, dz) = self._x, self._drawn(self._tick)
            a, b = self._kept, self._fresh
            self._x = (a * x + b * dx, a * y + b * dy, a * z + b * dz)
        return self._x

    def _drawn(self, tick: int) -> Vec3:
        """Return three normal numbers; drawn for many ticks at once."""
        block = tick // _BLOCK_TICKS
        if block != self._block:
            rng = generator(self._seed, Purpose.CURRENT, self._owner, block)
            self._normals = rng.standard_normal((_BLOCK_TICKS, 3)).tolist()
            self._block = block
        x, y, z = self._normals[tick % _BLOCK_TICKS]
        return (x, y, z)
