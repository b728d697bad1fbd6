"""
Potentials of chapter 4: a hollow cylinder to steer to, and layers around vehicles to stay out of.

The ring lies between two coaxial vertical cylinders. With d = p - centre its region functions, thesis Eq.
(4.3),

    f1 = r^2 - dx^2 - dy^2,      f2 = dx^2 + dy^2 - R^2,      f3 = dz^2 - (h/2)^2      (m^2)

are all <= 0 in it. Its potential, Eqs. (4.5)-(4.6), is E = sum_l k_l/2 max(0, f_l)^2; a layer of radius r_u
around another vehicle has s_u = r_u^2 - |p_ij|^2 and P = sum_u k_u/2 max(0, s_u)^2, Eqs. (4.7)-(4.9). With k
in 1/m^3 a potential is a length and its gradient is dimensionless; a law multiplies it by a force.

Deviation: p_ij is the difference of positions only; the thesis includes Euler angles, which has no meaning
as a distance. The signs in (4.3) are not legible; with the other sign f1 would draw vehicles into the hole.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.geometry import Box, Vec3

Layers = tuple[tuple[float, float], ...]
"""Radius (m) and gain (1/m^3) of each layer."""


@dataclass(frozen=True, slots=True)
class Ring:
    """A hollow vertical cylinder: both radii (m), height (m) and centre (m; NED)."""

    inner_radius_m: float
    outer_radius_m: float
    height_m: float
    centre_ned_m: Vec3

    @property
    def box(self) -> Box:
        """The box around the ring (m; NED)."""
        (x, y, z), r, h = self.centre_ned_m, self.outer_radius_m, 0.5 * self.height_m
        return Box((x - r, y - r, z - h), (x + r, y + r, z + h))


def region_functions(position: Vec3, ring: Ring) -> Vec3:
    """Return f1 (hole), f2 (outside) and f3 (above or below), thesis Eqs. (4.3)-(4.4) (m^2)."""
    x, y, z = position
    cx, cy, cz = ring.centre_ned_m
    squared = (x - cx) ** 2 + (y - cy) ** 2
    half_m = 0.5 * ring.height_m
    return ring.inner_radius_m**2 - squared, squared - ring.outer_radius_m**2, (z - cz) ** 2 - half_m * half_m


def region_potential(position: Vec3, ring: Ring, gain_pm3: float) -> float:
    """Return E, thesis Eqs. (4.5)-(4.6) (m); zero in the ring."""
    return 0.5 * gain_pm3 * sum([f * f for f in region_functions(position, ring) if f > 0.0])


def region_gradient(position: Vec3, ring: Ring, gain_pm3: float) -> Vec3:
    """
    Return dE/dp, the region error of the thesis's unnumbered equation after (4.6) (its "(11)"); NED.

    It is also zero on the axis, where the hole's potential has its maximum: a vehicle exactly there stays.
    """
    hole, outside, above = region_functions(position, ring)
    level = 2.0 * gain_pm3 * (max(0.0, outside) - max(0.0, hole))
    upright = 2.0 * gain_pm3 * max(0.0, above)
    cx, cy, cz = ring.centre_ned_m
    return level * (position[0] - cx), level * (position[1] - cy), upright * (position[2] - cz)


def distance_to_ring_m(position: Vec3, ring: Ring) -> float:
    """Return the distance to the nearest point of the ring (m), 0 in it."""
    x, y, z = position
    cx, cy, cz = ring.centre_ned_m
    axis_m = math.hypot(x - cx, y - cy)
    level_m = max(0.0, ring.inner_radius_m - axis_m, axis_m - ring.outer_radius_m)
    return math.hypot(level_m, max(0.0, abs(z - cz) - 0.5 * ring.height_m))


def layer_potential(own: Vec3, other: Vec3, layers: Layers) -> float:
    """Return P_ij of a pair, thesis Eqs. (4.7)-(4.9) (m); zero outside the widest layer."""
    squared = (own[0] - other[0]) ** 2 + (own[1] - other[1]) ** 2 + (own[2] - other[2]) ** 2
    inside = [(radius_m * radius_m - squared, gain_pm3) for radius_m, gain_pm3 in layers]
    return 0.5 * sum([gain_pm3 * s * s for s, gain_pm3 in inside if s > 0.0])


def layer_gradient(own: Vec3, other: Vec3, layers: Layers) -> Vec3:
    """
    Return dP_ij/dp_i, thesis Eq. (4.10); NED.  It is minus dP_ij/dp_j: action and reaction.

    For two vehicles at the same position it is zero, since there is no direction.
    """
    dx, dy, dz = own[0] - other[0], own[1] - other[1], own[2] - other[2]
    squared = dx * dx + dy * dy + dz * dz
    slope = 0.0
    for radius_m, gain_pm3 in layers:
        s = radius_m * radius_m - squared
        if s > 0.0:
            slope -= 2.0 * gain_pm3 * s
    return slope * dx, slope * dy, slope * dz
