"""Repel with a strength that grows with the square of the other's depth inside the spacing."""

from dataclasses import dataclass

from auv_core.geometry import Vec3, distance
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """One strength."""

    strength_mps: float = param("velocity at contact (m/s)", default=1.0, above=0.0, maximum=10.0)


class Separation:
    """Repulsion inside the spacing distance."""

    def __init__(self, params: Params) -> None:
        self._strength_mps = params.strength_mps

    def velocity(self, own: Vec3, other: Vec3, spacing_m: float) -> Vec3:
        """Return the velocity (m/s; NED) away from `other`."""
        range_m = distance(own, other)
        if not 0.0 < range_m < spacing_m:
            return (0.0, 0.0, 0.0)
        factor = self._strength_mps * (1.0 - range_m / spacing_m) ** 2 / range_m
        return (factor * (own[0] - other[0]), factor * (own[1] - other[1]), factor * (own[2] - other[2]))
