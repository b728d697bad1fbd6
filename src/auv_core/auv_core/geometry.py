"""
Attitude and vectors on plain floats.

Frames: world is NED (north, east, down), body is FRD (forward, right, down). A quaternion ``(w, x, y, z)`` is
a unit quaternion that maps body to NED. All functions work on tuples of floats, so that one vehicle needs no
arrays and Numba can compile the same source.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from auv_core.compiled import inlined, inner

Vec3 = tuple[float, float, float]
Quat = tuple[float, float, float, float]


class Box(NamedTuple):
    """A region between two corners, of the smallest and of the largest coordinates (m; NED)."""

    lowest: Vec3
    highest: Vec3

    def grown(self, by_m: float, down_m: float | None = None) -> Box:
        """Return the box with `by_m` added on every side; above and below `down_m`, if given."""
        (a, b, c), (d, e, f) = self
        dz = by_m if down_m is None else down_m
        return Box((a - by_m, b - by_m, c - dz), (d + by_m, e + by_m, f + dz))

    def holds(self, point: Vec3) -> bool:
        """Return whether a point lies in the box or on its faces."""
        return all(low <= x <= high for low, x, high in zip(self.lowest, point, self.highest, strict=True))


@inlined
def body_to_ned(q: Quat, v: Vec3) -> Vec3:
    """Return the body vector `v` in NED."""
    w, x, y, z = q
    tx, ty, tz = 2.0 * (y * v[2] - z * v[1]), 2.0 * (z * v[0] - x * v[2]), 2.0 * (x * v[1] - y * v[0])
    return (
        v[0] + w * tx + y * tz - z * ty,
        v[1] + w * ty + z * tx - x * tz,
        v[2] + w * tz + x * ty - y * tx,
    )


@inlined
def ned_to_body(q: Quat, v: Vec3) -> Vec3:
    """Return the NED vector `v` in the body frame; the inverse of `body_to_ned`."""
    return body_to_ned((q[0], -q[1], -q[2], -q[3]), v)


@inner
def quaternion_from_heading(heading_rad: float) -> Quat:
    """Return the attitude of a level vehicle with the given heading (rad, from north towards east)."""
    return (math.cos(0.5 * heading_rad), 0.0, 0.0, math.sin(0.5 * heading_rad))


@inner
def heading_from_quaternion(q: Quat) -> float:
    """Return the heading (rad, in (-pi, pi], from north towards east) of the body's forward axis."""
    w, x, y, z = q
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


@inner
def pitch_from_quaternion(q: Quat) -> float:
    """Return the pitch (rad, in [-pi/2, pi/2], nose up) of the body's forward axis."""
    w, x, y, z = q
    return math.asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0))


@inlined
def smallest_angle(angle_rad: float) -> float:
    """
    Return the angle in [-pi, pi) (rad).

    The smallest signed angle, ssa (Fossen 2021, Handbook of Marine Craft Hydrodynamics and Motion Control,
    Eq. 13.10).
    """
    return angle_rad - math.tau * math.floor((angle_rad + math.pi) / math.tau)


@inlined
def quaternion_product(a: Quat, b: Quat) -> Quat:
    """Return the Hamilton product a b: first rotate by b, then by a."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@inner
def distance(a: Vec3, b: Vec3) -> float:
    """Return the Euclidean distance of two points (m)."""
    x, y, z = a[0] - b[0], a[1] - b[1], a[2] - b[2]
    return math.sqrt(x * x + y * y + z * z)


@inner
def turned(v: Vec3, angle_rad: float) -> Vec3:
    """Return `v` (NED), turned about the vertical from north towards east."""
    cosine, sine = math.cos(angle_rad), math.sin(angle_rad)
    return (cosine * v[0] - sine * v[1], sine * v[0] + cosine * v[1], v[2])


@inlined
def limited(v: Vec3, length: float) -> Vec3:
    """Return `v`, shortened to at most `length`; the direction is kept."""
    norm = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    if norm <= length:
        return v
    scale = length / norm
    return (v[0] * scale, v[1] * scale, v[2] * scale)


@inlined
def clipped(value: float, most: float) -> float:
    """Return `value`, limited to [-`most`, `most`]."""
    if value > most:
        return most
    return max(value, -most)


@inlined
def added(a: Vec3, b: Vec3) -> Vec3:
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])
