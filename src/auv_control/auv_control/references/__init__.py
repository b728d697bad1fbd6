"""
References: the path in space and time that a vehicle follows.

To add one, write one file with ``Params`` and ``Reference(params)``, a `ReferencePath`.  The file's name is
its ``kind``.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Box, Vec3
from auv_core.params import Section

_STANDS_M2PS2 = 1e-6


class PathPoint(NamedTuple):
    """
    The reference at one instant.

    Position (m), velocity (m/s) and acceleration (m/s^2) in NED; heading (rad, from north towards east) with
    its rate (rad/s) and acceleration (rad/s^2).
    """

    position: Vec3
    velocity: Vec3
    acceleration: Vec3 = (0.0, 0.0, 0.0)
    heading_rad: float = 0.0
    heading_rate_radps: float = 0.0
    heading_acceleration_radps2: float = 0.0

    @property
    def turn_rate_radps(self) -> float:
        """
        Rate at which the velocity turns about the vertical (rad/s; from north to east), 0 if it stands.
        """
        (vx, vy, _), (ax, ay, _) = self.velocity, self.acceleration
        square_m2ps2 = vx * vx + vy * vy
        return (vx * ay - vy * ax) / square_m2ps2 if square_m2ps2 > _STANDS_M2PS2 else 0.0


class ReferencePath(Protocol):
    """A path; `period_s` is the time of one round (s), or None."""

    period_s: float | None

    def at(self, t_s: float) -> PathPoint:
        """Return the point at a time (s); its rates are the exact derivatives of its values."""

    def reach(self, duration_s: float) -> Box:
        """Return a box that the path does not leave in that time (m; NED)."""


def make_reference(section: Section) -> ReferencePath:
    """Return the path of a section."""
    path: ReferencePath = fulfilled(
        class_of(__name__, section.kind, "Reference")(section.params), ReferencePath
    )
    return path
