"""
Flocking laws: from what a vehicle knows to the velocity that it asks of itself.

To add one, write one file with ``Params`` and ``Flocking(params, separation, is_leader)`` with

* ``flock_velocity(path, centre, heard) -> Vec3``: what this vehicle believes the flock's velocity to be
  (m/s; NED), from the path point (leaders use it, blind followers must not), its own estimate of the centre,
  and the list of the neighbours' beliefs;
* ``velocity(view) -> Vec3``: the velocity over ground (m/s; NED) for the `View` of one instant;
* ``adapt(view, dt_s)``: called by the sampled agent after `velocity`, once per control period, for separation
  laws that learn; nothing to do for the others.

The first two are pure functions of their arguments, so that the sampled agent and the continuous-time
runner use the same law.  Where `velocity` looks at the flock's velocity, ``Params`` says so with a property
``uses_flock_velocity``: packets carry it, so such a law is refused in continuous time.  The file's name
is its ``kind``.
"""

from __future__ import annotations

from dataclasses import dataclass

from auv_control.references import PathPoint
from auv_core.geometry import Vec3


@dataclass(frozen=True, slots=True)
class View:
    """What one vehicle knows at one instant; positions in m, velocities in m/s, all NED."""

    position: Vec3
    centre: Vec3
    flock_velocity: Vec3
    neighbours: tuple[Vec3, ...]
    obstacles: tuple[tuple[Vec3, float], ...]
    path: PathPoint
