"""Claims of statuses that hold once the clock has stood by them for a while."""

from __future__ import annotations

from collections.abc import Collection


class StandingClaims:
    """
    Names of what statuses claim of a run that goes on.

    The clock speaks at least twice a second, and repeats a loss in every status. A claim that the next status
    leaves out is somebody else's word.

    Parameters
    ----------
    patience_s : float
        How long every status must repeat a claim (s).

    """

    def __init__(self, patience_s: float) -> None:
        self._patience_s = patience_s
        self._stood_s: dict[str, float] = {}

    def hear(self, claimed: Collection[str]) -> list[str]:
        """Take all that a status claims; return what it leaves out of what was claimed before."""
        left_out = [name for name in self._stood_s if name not in claimed]
        self._stood_s = {name: self._stood_s.get(name, 0.0) for name in claimed}
        return left_out

    def time_passed(self, awake_s: float) -> list[str]:
        """Let `awake_s` of wall time pass (s); return what holds now, each name once."""
        self._stood_s = {name: stood_s + awake_s for name, stood_s in self._stood_s.items()}
        holding = [name for name, stood_s in self._stood_s.items() if stood_s > self._patience_s]
        for name in holding:
            del self._stood_s[name]
        return holding
