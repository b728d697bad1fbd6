"""
Layers of depth, one for every vehicle that is not in its slot, and slots with a stagger in depth.

The layers are multiples of `step_m` above and below the depths of the formation, the nearest first, so that a
vehicle on its way to its lane is never at the depth of a slot or of another layer.
"""

from __future__ import annotations

from collections.abc import Sequence

from auv_core.geometry import Vec3

SAME_LANE_M = 1e-6
LEAST_GAP_M = 5.5
"""Least difference of depth between a layer and a slot (m): 5 m, and the overshoot of the depth autopilot."""


def staggered(slots: Sequence[Vec3], step_m: float) -> tuple[Vec3, ...]:
    """
    Return slots (m; along the course, to starboard, down) in which those of one lane are at different depths.

    Each is `step_m` deeper than the next one ahead in its lane: a vehicle that is lost rises astern of it.
    """
    return tuple((x, y, z + step_m * _ahead(slots, x, y)) for x, y, z in slots)


def _ahead(slots: Sequence[Vec3], x: float, y: float) -> int:
    return sum(1 for ahead in slots if abs(ahead[1] - y) < SAME_LANE_M and ahead[0] > x)


def layer_depths(
    slots: Sequence[Vec3],
    depth_m: float,
    step_m: float,
    *,
    also: Sequence[Vec3] = (),
    only_below: bool = False,
) -> tuple[float, ...]:
    """
    Return the depth of each vehicle's layer (m).

    Parameters
    ----------
    slots : sequence of (3,) tuple
        Offsets of all slots (m; along the course, to starboard, down).
    depth_m : float
        Depth of the formation (m).
    step_m : float
        Difference of depth between layers (m).
    also : sequence of (3,) tuple
        Slots of a shape to which the fleet switches (m).
    only_below : bool
        Whether all layers are below the formation, for shallow water.

    Raises
    ------
    ValueError
        For a layer above the surface.

    """
    lowest_m = depth_m + max(slot[2] for slot in (*slots, *also))
    highest_m = depth_m + min(slot[2] for slot in (*slots, *also))
    layers = []
    for index in range(len(slots)):
        if only_below:
            layers.append(lowest_m + (index + 1) * step_m)
        elif index % 2 == 0:
            layers.append(lowest_m + (index // 2 + 1) * step_m)
        else:
            layers.append(highest_m - (index // 2 + 1) * step_m)
    if min(layers) <= 0.0:
        raise ValueError(
            f"depth_m: {depth_m!r} is not allowed; allowed: more than {depth_m - min(layers):g} m for "
            f"{len(slots)} layers of {step_m:g} m, or layers only below"
        )
    return tuple(layers)


def check_layers(layers: Sequence[float], slots: Sequence[Vec3], depth_m: float) -> None:
    """
    Check that no vehicle crosses another one's slot in its layer.

    Raises
    ------
    ValueError
        If a layer is too close to the depth of another vehicle's slot.

    """
    for vehicle, layer_m in enumerate(layers):
        for other, slot in enumerate(slots):
            gap_m = abs(layer_m - (depth_m + slot[2]))
            if vehicle != other and gap_m < LEAST_GAP_M:
                raise ValueError(
                    f"layer_step_m: a gap of {gap_m:.3g} m between the layer of vehicle {vehicle + 1} and "
                    f"the slot of vehicle {other + 1} is not allowed; allowed: at least {LEAST_GAP_M} m"
                )
