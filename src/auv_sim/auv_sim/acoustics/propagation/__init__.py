"""
Propagation: travel time and transmission loss of sound between two places.

To add one, write one file with ``Params`` and ``Propagation(params)``, a `SoundPropagation`. A file that
needs an optional dependency raises ValueError, ``propagation.kind: ...``, if that is missing. ``Params`` has
``water_depth_m`` if the water has a bottom.
"""

from __future__ import annotations

import math
from typing import Protocol, runtime_checkable

from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Vec3
from auv_core.params import Section


class SoundPropagation(Protocol):
    """Sound between two places (m; NED)."""

    def delay_s(self, source: Vec3, receiver: Vec3) -> float:
        """Return the travel time (s)."""

    def loss_db(self, source: Vec3, receiver: Vec3, frequency_khz: float) -> float:
        """Return the transmission loss (dB); only modems with sound levels use it."""


@runtime_checkable
class _WithBottom(Protocol):
    water_depth_m: float


def make_propagation(section: Section) -> SoundPropagation:
    """Return the propagation of a section."""
    made = class_of(__name__, section.kind, "Propagation")(section.params)
    propagation: SoundPropagation = fulfilled(made, SoundPropagation)
    return propagation


def bottom_m(section: Section) -> float:
    """Return the depth of the water (m; inf without a bottom)."""
    return section.params.water_depth_m if isinstance(section.params, _WithBottom) else math.inf
