"""The obstacles in the water: where each of them is at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from auv_core.geometry import Vec3, added
from auv_core.params import Section, param
from auv_sim.obstacles import make_motion, still

MOTIONS = "auv_sim.obstacles"
STILL = Section("still", still.Params())
MAX_M = 1e5


@dataclass(frozen=True, kw_only=True)
class ObstacleConfig:
    """One obstacle as the water knows it."""

    position_ned_m: Vec3 = param("position, of a moving one at 0 s (m; NED)", minimum=-MAX_M, maximum=MAX_M)
    known: bool = param(
        "whether every vehicle knows it from the start; if not, vehicles must sense it", default=True
    )
    motion: Section = param("how it moves", default=STILL, plugins=MOTIONS)

    @property
    def is_moving(self) -> bool:
        """Whether it is of any other kind than `still`."""
        return self.motion.kind != STILL.kind


class ObstacleField:
    """The obstacles of a run, in the order of the scenario; `is_known` has one flag for each."""

    def __init__(self, obstacles: Sequence[ObstacleConfig]) -> None:
        self._places = [(each.position_ned_m, make_motion(each.motion)) for each in obstacles]
        self.is_known = [each.known for each in obstacles]

    def at(self, t_s: float) -> tuple[Vec3, ...]:
        """Return the positions of the obstacles at `t_s` (m; NED)."""
        return tuple([added(start, motion.offset(t_s)) for start, motion in self._places])
