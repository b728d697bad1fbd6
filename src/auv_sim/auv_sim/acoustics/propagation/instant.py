"""No delay and no loss: the medium that the thesis assumes in ch. 5 without communication limits."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.geometry import Vec3
from auv_sim.acoustics.propagation import SoundPropagation


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


class Propagation(SoundPropagation):
    """Sound arrives at once and without loss."""

    def __init__(self, params: Params) -> None:
        del params

    def delay_s(self, source: Vec3, receiver: Vec3) -> float:
        """Return 0 s."""
        del source, receiver
        return 0.0

    def loss_db(self, source: Vec3, receiver: Vec3, frequency_khz: float) -> float:
        """Return 0 dB."""
        del source, receiver, frequency_khz
        return 0.0
