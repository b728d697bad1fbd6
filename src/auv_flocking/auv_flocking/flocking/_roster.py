"""
Which vehicles are alive and which slot each has, as one vehicle knows it.

A vehicle is lost if no news of it is younger than a time-out; see `auv_control.formations.repair`. Slots
follow from the live vehicles and the shape alone, so that vehicles that know the same agree.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

from auv_control.formations.assignment import assigned_slots
from auv_control.formations.frame import Offset
from auv_control.formations.references import Weights, reference_weights
from auv_control.formations.repair import Word, ages_of_news_s, elected_leader, live_addresses, repaired_slots
from auv_control.formations.shapes import NO_SLOT, Slots, predecessors
from auv_control.formations.switching import Transition
from auv_core.geometry import Vec3
from auv_flocking.flocking import Member
from auv_flocking.heard import bit_of
from auv_flocking.neighbours.estimates import HEARD_MASK, HEARD_WITHIN, TIME, Estimates

SlotsOf = Callable[[int], Slots]


class Order(NamedTuple):
    """
    A formation of the live vehicles.

    slots : mapping
        The slot of each live vehicle, by address.
    leader : int
        Address of the leader.
    weights : Weights
        The references of the slots.

    """

    slots: dict[int, int]
    leader: int
    weights: Weights


class Roster:
    """
    The order of a fleet, kept by one vehicle.

    Parameters
    ----------
    member : Member
        Its place in the fleet.
    shares : mapping
        The reference type; see `auv_control.formations.references`.
    slots_of : callable
        The slots of the shape for a number of vehicles (m; frame of the formation). At the start the vehicle
        with address a has slot a - 1.
    timeout_s, move_s : float
        Silence after which a vehicle is lost, and the time of a move to another slot (s).

    """

    def __init__(
        self, member: Member, shares: Mapping[str, float], slots_of: SlotsOf, timeout_s: float, move_s: float
    ) -> None:
        self._member = member
        self._shares = shares
        self._slots_of = slots_of
        self._timeout_s = timeout_s
        self._move_s = move_s
        self._full = slots_of(member.fleet_size)
        self._live = tuple(range(1, member.fleet_size + 1))
        self._ways = {a: Transition(self._full[a - 1], self._full[a - 1]) for a in self._live}
        self._last: dict[int, tuple[float, Vec3]] = {}
        self.order = self._ordered(self._full)

    @property
    def wrecks(self) -> tuple[Vec3, ...]:
        """Where the lost vehicles were when they were last heard (m; NED)."""
        return tuple(place for address, (_, place) in self._last.items() if address not in self._live)

    @property
    def state(self) -> tuple[float, ...]:
        """The slot of each address from 1 on, `NO_SLOT` for lost vehicles."""
        slots, fleet_size = self.order.slots, self._member.fleet_size
        return tuple(float(slots.get(address, NO_SLOT)) for address in range(1, fleet_size + 1))

    @property
    def live(self) -> tuple[int, ...]:
        """Addresses of the live vehicles, ascending."""
        return self._live

    def notice(self, t_s: float, estimates: Estimates) -> None:
        """
        Update the live vehicles; if they have changed, move to the slots of the remaining formation.

        A vehicle that has news of none keeps its list: it may be deaf itself.
        """
        heard_s = dict(zip(estimates.addresses, estimates.column(TIME), strict=True))
        for (address, time_s), place in zip(heard_s.items(), estimates.positions(), strict=True):
            if self._last.get(address, (-math.inf, place))[0] < time_s:
                self._last[address] = time_s, place
        ages_s = ages_of_news_s(t_s, heard_s, self._words(estimates))
        live = live_addresses(self._member.address, self._member.fleet_size, ages_s, t_s, self._timeout_s)
        if len(live) > 1:
            self.count_on(live, t_s)

    def count_on(self, live: tuple[int, ...], t_s: float) -> None:
        """Take these vehicles (addresses, ascending) for the live ones from `t_s` on."""
        if live != self._live:
            self._live = live
            self._regroup(t_s)

    def switch(self, slots_of: SlotsOf, t_s: float) -> None:
        """Move to another shape from `t_s` on."""
        after = slots_of(self._member.fleet_size)
        self._full = tuple(after[slot] for slot in assigned_slots(self._full, after))
        self._slots_of = slots_of
        self._regroup(t_s)

    def offset(self, address: int, t_s: float) -> Offset:
        """Return the offset of a vehicle at a time (m, m/s, m/s^2; frame of the formation)."""
        return self._ways[address].at(t_s)

    def _regroup(self, t_s: float) -> None:
        slots = self._slots_of(len(self._live))
        self.order = self._ordered(slots)
        for address, slot in self.order.slots.items():
            way = self._ways[address]
            if way.after != slots[slot]:
                self._ways[address] = way.turned_to(slots[slot], t_s, self._move_s)

    def _ordered(self, slots: Slots) -> Order:
        taken = repaired_slots(self._live, self._full, slots)
        leader = elected_leader(self._live)
        followed = predecessors(slots, taken[leader])
        return Order(taken, leader, reference_weights(self._shares, followed))

    def _words(self, estimates: Estimates) -> Iterator[Word]:
        """Return what the neighbours say of others."""
        columns = (estimates.column(each) for each in (TIME, HEARD_WITHIN, HEARD_MASK))
        for speaker, time_s, within_s, mask in zip(estimates.addresses, *columns, strict=True):
            for address in range(1, self._member.fleet_size + 1):
                if address != speaker and int(mask) & bit_of(address):
                    yield Word(address, time_s, within_s)
