"""
A velocity that must lie on one side of several planes, moved there with little change.

A half-space is a pair (n, b) of a unit vector and a bound (m/s): velocities v with n . v >= b are allowed.
A barrier function gives such conditions: with h = distance - smallest distance, h_dot >= -rate h is one
half-space for each neighbour (Ames et al. 2019, Control Barrier Functions: Theory and Applications).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from auv_core.compiled import inner
from auv_core.geometry import Vec3

HalfSpaces = NDArray[np.float64]

_PASSES = 8


@inner
def into_half_spaces(velocity: Vec3, half_spaces: HalfSpaces) -> Vec3:
    """
    Return a velocity near `velocity` that lies in all half-spaces (m/s; same frame).

    The velocity is projected onto the planes in turn (Kaczmarz; projections onto convex sets), at most
    `_PASSES` times each. An allowed velocity is returned unchanged. A single plane is met exactly, several
    are met approximately, and contradictory bounds give a compromise.

    Parameters
    ----------
    velocity : (3,) tuple
        Desired velocity (m/s).
    half_spaces : (k, 4) array
        Unit normals n, and least velocities b along them (m/s).

    """
    x, y, z = velocity
    for _ in range(_PASSES):
        is_inside = True
        for k in range(len(half_spaces)):
            nx, ny, nz = float(half_spaces[k, 0]), float(half_spaces[k, 1]), float(half_spaces[k, 2])
            short_mps = float(half_spaces[k, 3]) - (nx * x + ny * y + nz * z)
            if short_mps > 1e-12:
                x, y, z = x + short_mps * nx, y + short_mps * ny, z + short_mps * nz
                is_inside = False
        if is_inside:
            break
    return (x, y, z)
