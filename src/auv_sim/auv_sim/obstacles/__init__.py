"""
Motions of obstacles: how far an obstacle is from its first position, as a function of time.

To add one, write one file with ``Params`` and ``Motion(params)``, an `ObstacleMotion`.  The file's name is
its ``kind``.
"""

from __future__ import annotations

from typing import Protocol

from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Vec3
from auv_core.params import Section


class ObstacleMotion(Protocol):
    """The motion of one obstacle. It depends on time alone: an obstacle does not react to vehicles."""

    def offset(self, t_s: float) -> Vec3:
        """Return the displacement from the first position at `t_s` (m; NED); zero at 0 s."""


def make_motion(section: Section) -> ObstacleMotion:
    """Return the motion of a section."""
    made = class_of(__name__, section.kind, "Motion")(section.params)
    motion: ObstacleMotion = fulfilled(made, ObstacleMotion)
    return motion
