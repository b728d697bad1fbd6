"""
Layers of depth: each vehicle has a depth of its own, known before the dive.

Two vehicles that know nothing of each other cannot keep apart by any law of what they know. Those at sea are
given different depths for this case. The layers lie around one depth z_m, a vehicle's by its address i of N:

    z_i = z_m + ((i - 1) / (N - 1) - 1 / 2) H,        H = min((N - 1) layer_m, layer_span_m)
    z_dot = limited(k_z (z_i - z), v_z)

A vehicle keeps its layer while it has not heard some other vehicle for `silent_s`; at 0, always. It needs no
news from the other. At 0 it goes to its layer straight up or down first, and stays there until it has heard
all, or until all others have had the time to reach theirs. So vehicles cross where they are, and what others
know of one on its way stays true: old news misplaces a vehicle that goes with the flock. Before a known
vehicle that is in the way it stops, and steps aside first.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

from auv_core.compiled import inner
from auv_core.geometry import Vec3, clipped
from auv_flocking.flocking import Member

_GAIN_PS = 0.3
_SPEED_MPS = 0.25
_NEAR_M = 0.3
_STEEP = 0.5
_ASIDE_MPS = 0.2
_NO_DIRECTION_M = 1e-9
_CROSSING_SIGMAS = 2.0
_UNFORESEEN_MPS = 0.05
_CROSSING_MARGIN_LIMIT_M = 2.5


class Layering(NamedTuple):
    """
    How a vehicle takes its layer.

    sinking_mps: velocity downwards towards it (m/s; NaN: no layer); is_in: 1 in it, 0 on the way; may_leave:
    1 if it may go with the flock; highest_m: depth of the highest layer; pitch_m: distance of two layers.
    """

    sinking_mps: float
    is_in: float
    may_leave: float
    highest_m: float
    pitch_m: float


NO_LAYER = Layering(math.nan, 0.0, 1.0, 0.0, 0.0)


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

    @property
    def silent_s(self) -> float:
        """Age of news from which a vehicle takes its layer (s); 0: always."""

    @property
    def settling_s(self) -> float:
        """Time after which all others have reached their layers (s)."""


def layers_height_m(layers: Layers, fleet_size: int) -> float:
    """Return the distance H of the highest and the lowest layer of a fleet (m), 0 without layers."""
    if layers.layer_depth_m is None:
        return 0.0
    return min(layers.layer_m * (fleet_size - 1), layers.layer_span_m)


class OwnLayer(NamedTuple):
    """The layer of one vehicle: its depth, depth of the highest layer, and distance of two layers (m)."""

    depth_m: float
    highest_m: float
    pitch_m: float

    def holds(self, depth_m: float) -> bool:
        """Return whether a vehicle at a depth (m) is in it."""
        return abs(self.depth_m - depth_m) <= _NEAR_M


def own_layer(layers: Layers, member: Member) -> OwnLayer | None:
    """Return the layer of a vehicle, None without layers; address 1 has the highest."""
    if layers.layer_depth_m is None:
        return None
    height_m = layers_height_m(layers, member.fleet_size)
    highest_m, pitch_m = layers.layer_depth_m - 0.5 * height_m, height_m / max(member.fleet_size - 1, 1)
    return OwnLayer(highest_m + (member.address - 1) * pitch_m, highest_m, pitch_m)


def layering(own: OwnLayer, depth_m: float, *, may_leave: bool) -> Layering:
    """
    Return how a vehicle takes its layer.

    Parameters
    ----------
    own : OwnLayer
        The layer.
    depth_m : float
        Depth of the vehicle (m).
    may_leave : bool
        Whether it may go with the flock.

    """
    sinking_mps = clipped(_GAIN_PS * (own.depth_m - depth_m), _SPEED_MPS)
    return Layering(sinking_mps, float(own.holds(depth_m)), float(may_leave), own.highest_m, own.pitch_m)


class LayerKeeper:
    """
    How one vehicle takes its layer. Its state is whether it has been in it.

    Parameters
    ----------
    layers : Layers
        Parameters of the law.
    member : Member
        The vehicle.

    """

    def __init__(self, layers: Layers, member: Member) -> None:
        self._layers, self._own = layers, own_layer(layers, member)
        self._others = member.fleet_size - 1
        self._has_arrived = False

    def layering(self, depth_m: float, known: int, silent_s: float, running_s: float) -> Layering:
        """
        Return how it takes its layer.

        Parameters
        ----------
        depth_m : float
            Its depth (m).
        known : int
            Number of vehicles that it has heard.
        silent_s, running_s : float
            Largest age of news, and time since the start (s).

        """
        own = self._own
        if own is None or silent_s < self._layers.silent_s:
            return NO_LAYER
        knows_all, is_settled = known >= self._others, running_s >= self._layers.settling_s
        is_in = own.holds(depth_m)
        if self._layers.silent_s > 0.0:
            may_leave = knows_all or (is_in and is_settled)
        else:
            may_leave = (self._has_arrived or is_in) and (knows_all or is_settled)
        return layering(own, depth_m, may_leave=may_leave)

    def note(self, layer: Layering) -> None:
        """Remember whether it has been in its layer, once per control period."""
        self._has_arrived = self._has_arrived or layer.is_in > 0.0


@inner
def aside(own: Vec3, other: Vec3, address: int, age_s: float, keep_m: float, layer: Layering) -> Vec3:
    """
    Return the velocity with which a vehicle steps out of the way of one that crosses its depth (m/s; NED).

    The neighbour may be anywhere between where it is estimated and where it would be if it had gone to its
    layer since the newest packet. A vehicle on the way to its own layer steps aside for what is ahead within
    `keep_m`; a vehicle in its layer for a neighbour that may be on its way through. Zero: all is clear.

    Parameters
    ----------
    own, other : (3,) tuple
        Own position, and the neighbour's estimated position (m; NED).
    address, age_s : int, float
        Its address, and the age of the estimate (s).
    keep_m : float
        The distance to keep (m).
    layer : Layering
        How the vehicle takes its layer.

    """
    left_m = layer.highest_m + (address - 1) * layer.pitch_m - other[2]
    there_m = other[2] + clipped(left_m, _SPEED_MPS * age_s)
    nearest_m = max(min(other[2], there_m), min(max(other[2], there_m), own[2]))
    ahead_m = (nearest_m - own[2]) * math.copysign(1.0, layer.sinking_mps)
    is_in_the_way = 0.0 <= ahead_m < keep_m
    if layer.is_in > 0.0:
        is_in_the_way = abs(there_m - other[2]) > _NEAR_M and abs(nearest_m - own[2]) < _NEAR_M
    x, y = own[0] - other[0], own[1] - other[1]
    level_m = math.hypot(x, y)
    if not is_in_the_way or level_m >= keep_m:
        return 0.0, 0.0, 0.0
    if level_m < _NO_DIRECTION_M:
        return _ASIDE_MPS, 0.0, 0.0
    return _ASIDE_MPS * x / level_m, _ASIDE_MPS * y / level_m, 0.0


@inner
def crossing_margin_m(sigma_m: float, age_s: float) -> float:
    """
    Return the margin to a neighbour whose depth a vehicle crosses on the way to its own layer (m).

    It is larger than that of the barrier, which grows with the neighbour's deviation only: a neighbour that
    steps aside itself leaves its prediction, and waiting for news costs a crossing vehicle time only.
    """
    return min(_CROSSING_SIGMAS * sigma_m + _UNFORESEEN_MPS * age_s, _CROSSING_MARGIN_LIMIT_M)


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
