"""Constant push inside the spacing distance."""

from dataclasses import dataclass

from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """One strength."""

    strength_mps: float = param("velocity inside the spacing distance (m/s)", default=0.3, above=0.0)


class Separation:
    """Away from the other, at one speed."""

    def __init__(self, params):
        self._strength_mps = params.strength_mps

    def velocity(self, own, other, spacing_m):
        """Return the velocity (m/s; NED)."""
        gap = [a - b for a, b in zip(own, other, strict=False)]
        range_m = sum(x * x for x in gap) ** 0.5
        if not 0.0 < range_m < spacing_m:
            return (0.0, 0.0, 0.0)
        return tuple(self._strength_mps * x / range_m for x in gap)
