"""No delay: the medium that the thesis assumes in ch. 5 without communication limits, and no water."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.geometry import Vec3


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


class Propagation:
    """Sound arrives at once."""

    def __init__(self, params: Params) -> None:
        del params

    def delay_s(self, source: Vec3, receiver: Vec3) -> float:
        """Return 0 s."""
        del source, receiver
        return 0.0
