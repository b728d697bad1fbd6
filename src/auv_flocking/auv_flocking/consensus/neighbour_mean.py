"""
The mean of the own position and of the estimated positions of the neighbours: no consensus, no state.

If all vehicles hear each other, it is the flocking centre with the delay and the error of the neighbour
estimates. A neighbour that is not heard is missing from the mean.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import entry, fastest
from auv_core.geometry import Vec3
from auv_core.params import param
from auv_flocking.codec import Field
from auv_flocking.consensus import ConsensusFilter
from auv_flocking.neighbours.estimates import Neighbours, position_rows


@dataclass(frozen=True)
class Params:
    """Parameters of the rate only; the mean has none."""

    follow_flock: bool = param(
        "whether the rate of the estimate is the flock's velocity instead of zero", default=True
    )

    @property
    def uses_flock_velocity(self) -> bool:
        """Whether the filter needs the flock's velocity from packets."""
        return self.follow_flock


@entry("TUPLE3(TUPLE3, float64[:, ::1])", allocates=False)
def mean(own: Vec3, rows: NDArray[np.float64]) -> Vec3:
    """Return the mean (m; NED) of a position and of those at the beginning of `rows` (n, 3 or more)."""
    x, y, z = own
    for k in range(len(rows)):
        x, y, z = x + float(rows[k, 0]), y + float(rows[k, 1]), z + float(rows[k, 2])
    count = 1 + len(rows)
    return (x / count, y / count, z / count)


class Consensus(ConsensusFilter):
    """One vehicle's filter."""

    shared_fields: tuple[Field, ...] = ()

    def __init__(self, params: Params, fleet_size: int) -> None:
        self._follow = params.follow_flock
        self._mean = fastest(mean)

    def centre(self, own: Vec3, heard: Neighbours) -> Vec3:
        """Return the mean position (m; NED)."""
        return self._mean(own, position_rows(heard))

    def advance(self, own: Vec3, heard: Neighbours, flock_velocity: Vec3, dt_s: float) -> Vec3:
        """Return the flock's velocity (m/s; NED), or zero if the filter does not use it."""
        return flock_velocity if self._follow else (0.0, 0.0, 0.0)

    def shared(self) -> tuple[float, ...]:
        """Return nothing: packets carry the position anyway."""
        return ()
