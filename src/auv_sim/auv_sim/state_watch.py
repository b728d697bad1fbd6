"""Which states of the vehicles a relay uses in real time: possible ones, while they are fresh."""

from __future__ import annotations

from collections.abc import Sequence

from auv_core.freshness import Newest, age_limit_s
from auv_core.messages import VehicleState
from auv_core.state_checks import checked_state


class StateWatch:
    """
    Judges the states of the vehicles, which are counted from 0.

    Attributes
    ----------
    packets_unsent : int
        Number of packets that were not sent, since nobody knew from where.
    left_out : int
        Number of states that were not used.
    left_out_words : str
        Which vehicle's was the last of them, and why.

    """

    def __init__(self, vehicle_ids: Sequence[str], max_age_s: float, period_s: float) -> None:
        self._ids = vehicle_ids
        limit_s = age_limit_s(max_age_s, period_s)
        self._newest: list[Newest[VehicleState]] = [Newest(limit_s, period_s) for _ in vehicle_ids]
        self.packets_unsent = 0
        self.left_out = 0
        self.left_out_words = ""

    def hear(self, index: int, state: VehicleState, now_tick: int) -> bool:
        """Take a state; return whether it is the vehicle's newest one now."""
        newest = self._newest[index]
        usable, words = checked_state(state)
        if usable is not None and newest.hear(usable, usable.tick, now_tick):
            return True
        self.left_out += 1
        self.left_out_words = f"{self._ids[index]}: {words or newest.dropped_words}"
        return False

    def may_send(self, index: int, now_tick: int, packets: int) -> bool:
        """Return whether a vehicle's packets go into the water, and count those that do not."""
        is_stale = bool(self.why_stale(index, now_tick))
        self.packets_unsent += packets * is_stale
        return not is_stale

    def why_stale(self, index: int, now_tick: int) -> str:
        """Return why the newest state of a vehicle is of no use now, or nothing."""
        words = self._newest[index].why_stale(now_tick)
        return f"state of {self._ids[index]} {words}" if words else ""

    def explained(self, awaited: str) -> str:
        """Return for whom the relay waits, with the state that was left out last, if any."""
        return f"{awaited}; left out: {self.left_out_words}" if awaited and self.left_out else awaited
