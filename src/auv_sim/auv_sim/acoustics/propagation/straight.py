"""Straight rays at one sound speed."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.geometry import Vec3, distance
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """One sound speed for the whole water."""

    sound_speed_mps: float = param("speed of sound in the water (m/s)", default=1500.0, above=0.0)


class Propagation:
    """Delay is range over sound speed."""

    def __init__(self, params: Params) -> None:
        self._speed_mps = params.sound_speed_mps

    def delay_s(self, source: Vec3, receiver: Vec3) -> float:
        """Return the travel time (s) between two NED positions (m)."""
        return distance(source, receiver) / self._speed_mps
