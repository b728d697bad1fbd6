"""
Switching between shapes: offsets that move on a quintic from one slot to another, thesis Section 1.10.3.
"""

from __future__ import annotations

from typing import NamedTuple

from auv_control.formations.frame import Offset
from auv_control.start_blend import blend
from auv_core.geometry import Vec3


class Transition(NamedTuple):
    """
    The way of a vehicle from one offset to another.

    before, after : Vec3
        The offsets (m; frame of the formation).
    start_s, duration_s : float
        When it begins and how long it lasts (s).

    """

    before: Vec3
    after: Vec3
    start_s: float = 0.0
    duration_s: float = 0.0

    def at(self, t_s: float) -> Offset:
        """Return the offset at a time, with its exact derivatives (m, m/s, m/s^2; frame of the formation)."""
        left, rate_ps, acceleration_ps2 = blend(t_s - self.start_s, self.duration_s)
        step = tuple(a - b for a, b in zip(self.before, self.after, strict=True))
        (x, y, z), (dx, dy, dz) = self.after, step
        return Offset(
            (x + left * dx, y + left * dy, z + left * dz),
            (rate_ps * dx, rate_ps * dy, rate_ps * dz),
            (acceleration_ps2 * dx, acceleration_ps2 * dy, acceleration_ps2 * dz),
        )

    def turned_to(self, after: Vec3, start_s: float, duration_s: float) -> Transition:
        """
        Return the way from where this one is at `start_s` to another offset.

        The offset is continuous. Its rate is too, unless this way is not over: then it starts at 0.
        """
        return Transition(self.at(start_s).position, after, start_s, duration_s)
