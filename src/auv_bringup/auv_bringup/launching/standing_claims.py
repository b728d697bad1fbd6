"""Claims in statuses that become valid once the clock has repeated them for a while."""

from __future__ import annotations

from collections.abc import Collection


class StandingClaims:
    """
    Names that statuses of a running flight claim, such as lost vehicles.

    The clock publishes at least twice a second, and repeats a loss in every status. A claim that is missing
    in the next status came from a foreign process.

    Parameters
    ----------
    patience_s : float
        How long every status must repeat a claim (s).

    """

    def __init__(self, patience_s: float) -> None:
        self._patience_s = patience_s
        self._stood_s: dict[str, float] = {}

    def hear(self, claimed: Collection[str]) -> list[str]:
        """Take all claims of a status; return earlier claims that it does not repeat."""
        left_out = [name for name in self._stood_s if name not in claimed]
        self._stood_s = {name: self._stood_s.get(name, 0.0) for name in claimed}
        return left_out

    def time_passed(self, awake_s: float) -> list[str]:
        """Let `awake_s` of wall time pass (s); return the claims that became valid, each name once."""
        self._stood_s = {name: stood_s + awake_s for name, stood_s in self._stood_s.items()}
        holding = [name for name, stood_s in self._stood_s.items() if stood_s > self._patience_s]
        for name in holding:
            del self._stood_s[name]
        return holding
