"""
Flocking laws: from what a vehicle knows to the velocity that it asks of itself.

To add one, write one file with ``Params`` and ``Flocking(params, separation, is_leader)`` with

* ``hear(estimates, dt_s)``: called by the sampled agent first of all, once per control period, for laws that
  measure how old their information is; nothing to do for the others;
* ``flock_velocity(t_s, path, centre, own, estimates) -> FlockVelocity``: what this vehicle believes the
  flock's velocity to be, from the path point (leaders use it, blind followers must not), its own estimate of
  the centre, its own latest belief, and the neighbours' beliefs in their estimates;
* ``velocity(view) -> Vec3``: the velocity over ground (m/s; NED) for the `View` of one instant;
* ``adapt(view, dt_s)``: called by the sampled agent after `velocity`, once per control period, for separation
  laws that learn; nothing to do for the others.

`flock_velocity` and `velocity` change nothing, so that the sampled agent and the continuous-time runner use
the same law.  ``Params`` has ``formation_spacing_m``, the largest distance that the law keeps between
neighbours (m), and ``largest_correction_mps``, the most that it adds to the velocity of the path (m/s; inf
for no limit), so that a scenario whose reports or actuators cannot follow is refused.  Where `velocity` looks
at the flock's velocity or at estimates, ``Params`` says so with a property ``uses_flock_velocity``: packets
carry them, so such a law is refused in continuous time.  The file's name is its ``kind``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from auv_control.references import PathPoint
from auv_core.geometry import Vec3
from auv_flocking.neighbours.estimates import NeighbourEstimate


class FlockVelocity(NamedTuple):
    """
    A belief of the flock's velocity (m/s; NED), and when a leader made it (s).

    It is passed on from vehicle to vehicle with its stamp; nobody's is stamped -inf.
    """

    velocity: Vec3
    stamp_s: float


NOTHING_HEARD = FlockVelocity((0.0, 0.0, 0.0), -math.inf)


class View(NamedTuple):
    """
    What one vehicle knows at one instant; positions in m, velocities in m/s, all NED.

    `neighbours` are the positions of `estimates`, in the same order; in continuous time, where everybody
    knows everything, there are no estimates.
    """

    position: Vec3
    centre: Vec3
    flock_velocity: Vec3
    neighbours: Sequence[Vec3]
    obstacles: tuple[tuple[Vec3, float], ...]
    path: PathPoint
    estimates: Sequence[NeighbourEstimate] = ()
