"""The lock-step barrier: who still owes an answer for the tick."""

from __future__ import annotations

from collections.abc import Sequence


class Barrier:
    """
    Collects, for one tick k, the packets that every vehicle handed over in k and every vehicle's state at k
    + 1.

    Vehicles are counted from 0.  Before the first tick (k = -1) only states are owed.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._lost: set[int] = set()
        self.tick = -1
        self._states_owed = set(range(count))
        self._outboxes_owed: set[int] = set()

    @property
    def complete(self) -> bool:
        """Whether everybody has answered."""
        return not self._states_owed and not self._outboxes_owed

    def owed(self) -> list[tuple[str, int]]:
        """
        Return who is awaited, as ('agent_node' or 'vehicle_node', vehicle).

        A vehicle cannot answer before its agent has commanded it, so of a pair that owes both only the agent
        is named.
        """
        agents = [("agent_node", vehicle) for vehicle in sorted(self._outboxes_owed)]
        return agents + [
            ("vehicle_node", vehicle) for vehicle in sorted(self._states_owed - self._outboxes_owed)
        ]

    def state(self, vehicle: int, tick: int) -> bool:
        """Note the state of a vehicle at a tick; return whether it was owed."""
        if tick != self.tick + 1 or vehicle not in self._states_owed:
            return False
        self._states_owed.discard(vehicle)
        return True

    def outbox(self, vehicle: int, tick: int) -> bool:
        """Note what a vehicle handed over in a tick; return whether it was owed."""
        if tick != self.tick or vehicle not in self._outboxes_owed:
            return False
        self._outboxes_owed.discard(vehicle)
        return True

    def advance(self) -> int:
        """Begin the next tick and return it."""
        self.tick += 1
        present = set(range(self._count)) - self._lost
        self._states_owed = set(present)
        self._outboxes_owed = set(present)
        return self.tick

    def drop(self, vehicles: Sequence[int]) -> None:
        """Go on without these vehicles."""
        self._lost.update(vehicles)
        self._states_owed.difference_update(vehicles)
        self._outboxes_owed.difference_update(vehicles)
