"""No outage."""

from __future__ import annotations

from dataclasses import dataclass

from auv_sim.acoustics.outage import PacketLoss


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


class Outage(PacketLoss):
    """Nothing is lost."""

    def __init__(self, params: Params, seed: int) -> None:
        del params, seed

    def lost(self, source: int, destination: int, sequence: int) -> bool:
        """Return False."""
        del source, destination, sequence
        return False
