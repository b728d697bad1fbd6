"""Selects the vehicle states that a relay uses in real time: plausible ones, while they are fresh."""

from __future__ import annotations

from collections.abc import Sequence

from auv_core.freshness import Newest, age_limit_s
from auv_core.messages import VehicleState
from auv_core.state_checks import checked_state


class StateWatch:
    """
    Checks the states of the vehicles, which are counted from 0.

    Attributes
    ----------
    vehicles : range
        All vehicles.
    packets_unsent : int
        Number of packets that were not sent, since the position of the modem was not known.
    left_out : int
        Number of states that were not used.
    left_out_words : str
        The vehicle of the last of them, and the reason.

    """

    def __init__(self, vehicle_ids: Sequence[str], max_age_s: float, period_s: float) -> None:
        self._ids = vehicle_ids
        self.vehicles = range(len(vehicle_ids))
        limit_s = age_limit_s(max_age_s, period_s)
        self._newest: list[Newest[VehicleState]] = [Newest(limit_s, period_s) for _ in vehicle_ids]
        self.packets_unsent = 0
        self.left_out = 0
        self.left_out_words = ""

    def hear(self, index: int, state: VehicleState, now_tick: int) -> bool:
        """Take a state; return whether it is now the vehicle's newest one."""
        newest = self._newest[index]
        usable, words = checked_state(state)
        if usable is not None and newest.hear(usable, usable.tick, now_tick):
            return True
        self.left_out += 1
        self.left_out_words = f"{self._ids[index]}: {words or newest.dropped_words}"
        return False

    def may_send(self, index: int, now_tick: int, packets: int) -> bool:
        """Return whether a vehicle's packets are transmitted, and count those that are not."""
        is_stale = bool(self.why_stale(index, now_tick))
        self.packets_unsent += packets * is_stale
        return not is_stale

    def why_stale(self, index: int, now_tick: int) -> str:
        """Return why the newest state of a vehicle cannot be used now, or an empty text."""
        words = self._newest[index].why_stale(now_tick)
        return f"state of {self._ids[index]} {words}" if words else ""

    def explained(self, awaited: str) -> str:
        """Return the vehicles that the relay waits for, with the last state that was left out, if any."""
        return f"{awaited}; left out: {self.left_out_words}" if awaited and self.left_out else awaited
