"""
Layers of depth for vehicles without news: each has a depth of its own, known before the dive.

Two vehicles that know nothing of each other cannot keep apart by any law of what they know. Those at sea are
given different depths for this case. The layers lie around one depth z_m, a vehicle's by its address i of N:

    z_i = z_m + (i - (N + 1) / 2) p,        p = min(layer_m, layer_span_m / (N - 1))
    z_dot = limited(k_z (z_i - z), v_z)

A vehicle takes its layer while it has not heard some other vehicle for `silent_s`. That needs no news from
the other: who does not hear takes a layer, and who does hear sees where the other goes.
"""

from __future__ import annotations

import math
from typing import Protocol

from auv_core.compiled import inner
from auv_core.geometry import Vec3
from auv_flocking.flocking import Member

_GAIN_PS = 0.3
_SPEED_MPS = 0.15
_NEAR_M = 0.3
_STEEP = 0.5

Layering = tuple[float, float]
"""Velocity downwards towards a layer (m/s; NaN: no layer), and 1 in it or 0 on the way."""

NO_LAYER: Layering = (math.nan, 0.0)


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


def layer_depth_m(layers: Layers, member: Member) -> float | None:
    """Return the depth of a vehicle's layer (m), the highest for address 1; None without layers."""
    if layers.layer_depth_m is None:
        return None
    pitch_m = min(layers.layer_m, layers.layer_span_m / max(member.fleet_size - 1, 1))
    return layers.layer_depth_m + (member.address - 0.5 * (member.fleet_size + 1)) * pitch_m


def layering(layer_depth_m: float, depth_m: float) -> Layering:
    """Return how a vehicle at `depth_m` takes the layer at `layer_depth_m` (m)."""
    below_m = layer_depth_m - depth_m
    sinking_mps = max(-_SPEED_MPS, min(_SPEED_MPS, _GAIN_PS * below_m))
    return sinking_mps, float(abs(below_m) <= _NEAR_M)


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
