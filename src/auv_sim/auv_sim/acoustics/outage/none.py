"""No outage."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


class Outage:
    """Nothing is lost."""

    def __init__(self, params: Params, seed: int) -> None:
        del params, seed

    def lost(self, source: int, destination: int, sequence: int) -> bool:
        """Return False."""
        del source, destination, sequence
        return False
