"""
Repair of a formation after a loss, thesis Section 1.10.4: noticed from silence alone.

A vehicle counts as lost if no news of it is younger than a time-out. News is a packet of its
own, or the word of another that it had one. The slots follow from the set of live vehicles and from nothing
else: vehicles that agree on the live set agree on all slots, whatever each of them thought before.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple

from auv_control.formations.assignment import assigned_slots
from auv_core.geometry import Vec3


class Word(NamedTuple):
    """
    News at second hand: at `time_s` a vehicle held a packet of `address` that was at most `within_s` old.
    """

    address: int
    time_s: float
    within_s: float


def ages_of_news_s(t_s: float, heard_s: Mapping[int, float], words: Iterable[Word]) -> dict[int, float]:
    """
    Return the age of the newest news of each vehicle (s), by address.

    Parameters
    ----------
    t_s : float
        Now (s).
    heard_s : mapping
        Time tag of the newest packet of each vehicle that was heard, by address (s).
    words : iterable of Word
        What those vehicles say of others.

    """
    newest_s = dict(heard_s)
    for word in words:
        told_s = word.time_s - word.within_s
        newest_s[word.address] = max(newest_s.get(word.address, told_s), told_s)
    return {address: t_s - time_s for address, time_s in newest_s.items()}


def live_addresses(
    own: int, fleet_size: int, ages_s: Mapping[int, float], silent_s: float, timeout_s: float
) -> tuple[int, ...]:
    """
    Return the addresses of the live vehicles, in ascending order; the own one is among them.

    Parameters
    ----------
    own, fleet_size : int
        Own address, and the number of vehicles at the start; their addresses begin with 1.
    ages_s : mapping
        Age of the news of each vehicle (s).
    silent_s : float
        Age of a vehicle of which there never were news: the time since the start (s).
    timeout_s : float
        Age from which a vehicle is lost (s).

    """
    return tuple(
        address
        for address in range(1, fleet_size + 1)
        if address == own or ages_s.get(address, silent_s) <= timeout_s
    )


def elected_leader(live: Sequence[int], knows_path: Collection[int] = ()) -> int:
    """Return the leader: the lowest live address of those that know the path, else the lowest of all."""
    return min((address for address in live if address in knows_path), default=min(live))


def repaired_slots(live: Sequence[int], before: Sequence[Vec3], after: Sequence[Vec3]) -> dict[int, int]:
    """
    Return the slot of each live vehicle, by address.

    The leader keeps no slot of its own: in a line that lost two vehicles on one side, one would have to pass
    through a leader that stays in the middle (a test). It leads from the slot that it gets.

    Parameters
    ----------
    live : sequence of int
        Addresses of the live vehicles.
    before : sequence of points
        Offset of each address, from 1 on, in the full formation (m; frame of the formation).
    after : sequence of points
        The slots of the formation of the live vehicles (m).

    """
    starts = [before[address - 1] for address in live]
    return dict(zip(live, assigned_slots(starts, after), strict=True))
