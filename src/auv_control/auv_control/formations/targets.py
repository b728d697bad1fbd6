"""
The desired motion of a vehicle in a formation, from what it knows of others.

    eta_d,i = w_i + sum_j W_ij (eta_j - w_j)

and the same for velocities and, if they are communicated, accelerations. The path counts as a further
vehicle, with offset 0.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from auv_control.formations.frame import Offset
from auv_control.references import PathPoint
from auv_core.geometry import Vec3

NO_OFFSET = Offset((0.0, 0.0, 0.0))


class Guide(NamedTuple):
    """
    A vehicle, or the path, by which another steers.

    Its weight, its motion and the world offset of its slot (m, m/s, m/s^2; NED). An acceleration that is not
    communicated is 0.
    """

    weight: float
    motion: Offset
    offset: Offset = NO_OFFSET


def guide_of_path(weight: float, path: PathPoint) -> Guide:
    """Return the path as a guide."""
    return Guide(weight, Offset(path.position, path.velocity, path.acceleration))


def desired_motion(own: Offset, guides: Iterable[Guide], *, uses_accelerations: bool) -> Offset:
    """
    Return the desired position, velocity and acceleration of a vehicle (m, m/s, m/s^2; NED).

    Parameters
    ----------
    own : Offset
        World offset of its slot.
    guides : iterable of Guide
        The vehicles by which it steers; their weights sum to 1.
    uses_accelerations : bool
        Whether the accelerations of the guides count. Without them the desired acceleration is 0, as for a
        vehicle that hears positions and velocities only.

    """
    position, velocity, acceleration = own
    for guide in guides:
        position = _moved(position, guide, 0)
        velocity = _moved(velocity, guide, 1)
        acceleration = _moved(acceleration, guide, 2)
    return Offset(position, velocity, acceleration if uses_accelerations else (0.0, 0.0, 0.0))


def _moved(start: Vec3, guide: Guide, order: int) -> Vec3:
    """Return `start` plus the weighted motion of a guide without its offset, or a derivative of these."""
    weight, moving, offset = guide.weight, guide.motion[order], guide.offset[order]
    return (
        start[0] + weight * (moving[0] - offset[0]),
        start[1] + weight * (moving[1] - offset[1]),
        start[2] + weight * (moving[2] - offset[2]),
    )
