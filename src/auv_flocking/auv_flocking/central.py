"""
Separation laws that act along the line between two points with one strength.

Such a law is a function ``strength(square_m2, spacing_m, numbers)``, marked as an `entry` with `STRENGTH`: of
the squared distance (m^2), the safety distance (m) and the law's own numbers it gives the factor (1/s) on
(own - other).  Compiled loops over all pairs of a flock call the same function as a single vehicle.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import entry, inlined
from auv_core.geometry import Vec3

STRENGTH = "float64(float64, float64, float64[::1])"

Numbers = NDArray[np.float64]
Strength = Callable[[float, float, Numbers], float]


@inlined
def along(own: Vec3, other: Vec3, spacing_m: float, strength: Strength, numbers: Numbers) -> Vec3:
    """Return the velocity (m/s; NED) of the vehicle at `own` because of `other`."""
    dx, dy, dz = own[0] - other[0], own[1] - other[1], own[2] - other[2]
    factor = strength(dx * dx + dy * dy + dz * dz, spacing_m, numbers)
    return (factor * dx, factor * dy, factor * dz)


@entry(STRENGTH)
def no_strength(square_m2: float, spacing_m: float, numbers: Numbers) -> float:
    """Return zero: the strength of a law without force."""
    return 0.0
