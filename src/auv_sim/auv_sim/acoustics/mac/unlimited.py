"""Everybody transmits in every control period and nobody disturbs anybody: no medium access at all."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


class Mac:
    """A transmission may start at every tick."""

    def __init__(self, params: Params, fleet_size: int) -> None:
        del params, fleet_size

    def opportunity_s(self, address: int, tick: int, period_s: float) -> float | None:
        """Return the time of the tick (s)."""
        del address
        return tick * period_s

    def check(self, airtime_s: float) -> None:
        """Accept every length."""
        del airtime_s
