"""What the mission plan tells of vehicles that have sent no packet yet: where each starts."""

from __future__ import annotations

import math
from collections.abc import Sequence

from auv_control.guidance.track import Track
from auv_core.geometry import Vec3
from auv_flocking.fleets import Start
from auv_flocking.lanes.status import STRAIGHT_ON, LaneNeighbour, LaneStatus, Mode


def planned(
    starts: Sequence[Start], track: Track, slots: Sequence[Vec3], layers_m: Sequence[float]
) -> list[LaneNeighbour]:
    """
    Return every vehicle of the plan at its start, on its way to its lane in its layer.

    Parameters
    ----------
    starts : sequence of Start
        In the order of addresses; empty without a plan.
    track : Track
        The track of the fleet.
    slots : sequence of (3,) tuple
        Offsets of all slots (m; along the course, to starboard, down).
    layers_m : sequence of float
        Depths of all layers (m).

    """
    plan = []
    for index, (position, heading_rad, speed_mps) in enumerate(starts):
        gamma_m = track.closest(position[0], position[1]) - slots[index][0]
        status = LaneStatus(gamma_m, 0.0, 0.0, Mode.TRANSIT, False, STRAIGHT_ON, layers_m[index])
        velocity = (speed_mps * math.cos(heading_rad), speed_mps * math.sin(heading_rad), 0.0)
        plan.append(LaneNeighbour(index + 1, 0.0, status, 0.0, position, velocity))
    return plan
