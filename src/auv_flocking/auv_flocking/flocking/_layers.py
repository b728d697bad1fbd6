"""
Layers of depth: each vehicle has a depth of its own, known before the dive.

Two vehicles that know nothing of each other cannot keep apart by any law of what they know. Those at sea are
given different depths for this case. The layers lie around one depth z_m, a vehicle's by its address i of N:

    z_i = z_m + ((i - 1) / (N - 1) - 1 / 2) H,        H = min((N - 1) layer_m, layer_span_m)
    z_dot = limited(k_z (z_i - z), v_z)

A vehicle keeps its layer while it has not heard some other vehicle for `silent_s`; at 0, always. It needs no
news from the other. On the way to its layer it does not go to the centre before it has heard all: who
crosses the depth of a vehicle that it does not know does so where it is.
"""

from __future__ import annotations

import math
from typing import Protocol

from auv_core.compiled import inner
from auv_core.geometry import Vec3
from auv_flocking.flocking import Member

_GAIN_PS = 0.3
_SPEED_MPS = 0.25
_NEAR_M = 0.3
_STEEP = 0.5

Layering = tuple[float, float, float]
"""
Velocity downwards towards a layer (m/s; NaN: no layer); 1 in it or 0 on the way; 1 if the vehicle may gather.
"""

NO_LAYER: Layering = (math.nan, 0.0, 1.0)


class Layers(Protocol):
    """Parameters of a law with layers."""

    @property
    def layer_depth_m(self) -> float | None:
        """Middle of the layers (m); None without layers."""

    @property
    def layer_m(self) -> float:
        """Largest distance of two neighbouring layers (m)."""

    @property
    def layer_span_m(self) -> float:
        """Largest distance of the highest and the lowest layer (m)."""


def layers_height_m(layers: Layers, fleet_size: int) -> float:
    """Return the distance H of the highest and the lowest layer of a fleet (m), 0 without layers."""
    if layers.layer_depth_m is None:
        return 0.0
    return min(layers.layer_m * (fleet_size - 1), layers.layer_span_m)


def layer_of(layers: Layers, member: Member) -> float | None:
    """Return the depth of a vehicle's layer (m), the highest for address 1; None without layers."""
    if layers.layer_depth_m is None:
        return None
    below_highest = (member.address - 1) / max(member.fleet_size - 1, 1)
    return layers.layer_depth_m + (below_highest - 0.5) * layers_height_m(layers, member.fleet_size)


def layering(layer_depth_m: float | None, depth_m: float, *, knows_all: bool) -> Layering:
    """
    Return how a vehicle takes its layer.

    Parameters
    ----------
    layer_depth_m, depth_m : float
        Depth of the layer, None without one, and own depth (m).
    knows_all : bool
        Whether it has heard every other vehicle.

    """
    if layer_depth_m is None:
        return NO_LAYER
    below_m = layer_depth_m - depth_m
    sinking_mps = max(-_SPEED_MPS, min(_SPEED_MPS, _GAIN_PS * below_m))
    is_in = abs(below_m) <= _NEAR_M
    return sinking_mps, float(is_in), float(is_in or knows_all)


@inner
def levelled(normal: Vec3, bound_mps: float, sinking_mps: float) -> tuple[Vec3, float]:
    """
    Return a half-space of the barrier for a vehicle that keeps its depth: the part of it in the horizontal.

    A neighbour nearly above or below bounds nothing.

    Parameters
    ----------
    normal, bound_mps : (3,) tuple, float
        The half-space of velocities v with normal . v >= bound (m/s; NED).
    sinking_mps : float
        Velocity downwards (m/s).

    """
    level = math.hypot(normal[0], normal[1])
    if level < _STEEP:
        return (1.0, 0.0, 0.0), -math.inf
    return (normal[0] / level, normal[1] / level, 0.0), (bound_mps - normal[2] * sinking_mps) / level
