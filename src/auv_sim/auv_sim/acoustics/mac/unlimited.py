"""Every modem transmits in every control period: no medium access control, for modems without airtime."""

from __future__ import annotations

from dataclasses import dataclass

from auv_sim.acoustics.mac import MediumAccess


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


class Mac(MediumAccess):
    """A transmission may start at every tick; with airtime above zero all packets collide."""

    def __init__(self, params: Params, fleet_size: int, seed: int) -> None:
        del params, fleet_size, seed

    def opportunity_s(self, address: int, tick: int, period_s: float) -> float | None:
        """Return the time of the tick (s)."""
        del address
        return tick * period_s

    def check(self, airtime_s: float) -> None:
        """Accept every length."""
        del airtime_s
