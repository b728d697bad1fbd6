"""
The mean of the own position and of the neighbours' positions as believed: no consensus, no memory.

In a fleet that all hear each other it is the flocking centre, as late and as wrong as the estimates of the
neighbours are.  Of a neighbour that is not heard it knows nothing: then the mean is that of the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from auv_core.geometry import Vec3
from auv_core.params import param
from auv_flocking.codec import Field
from auv_flocking.consensus import Heard
from auv_flocking.estimates import positions_of


@dataclass(frozen=True)
class Params:
    """The mean itself has nothing to choose."""

    follow_flock: bool = param(
        "say that the centre moves with the flock's velocity, instead of not at all", default=True
    )

    @property
    def uses_flock_velocity(self) -> bool:
        """Whether the filter needs what packets say of the flock's velocity."""
        return self.follow_flock


class Consensus:
    """One vehicle's filter."""

    shared_fields: tuple[Field, ...] = ()

    def __init__(self, params: Params, fleet_size: int) -> None:
        self._follow = params.follow_flock

    def centre(self, own: Vec3, heard: Sequence[Heard]) -> Vec3:
        """Return the mean position (m; NED)."""
        x, y, z = own
        for px, py, pz in positions_of(heard):
            x, y, z = x + px, y + py, z + pz
        count = 1 + len(heard)
        return (x / count, y / count, z / count)

    def advance(self, own: Vec3, heard: Sequence[Heard], flock_velocity: Vec3, dt_s: float) -> Vec3:
        """Return the flock's velocity (m/s; NED), or zero where the filter does not look at it."""
        return flock_velocity if self._follow else (0.0, 0.0, 0.0)

    def shared(self) -> tuple[float, ...]:
        """Return nothing: packets carry the position anyway."""
        return ()
