"""The lock-step barrier: which nodes have not answered for the tick."""

from __future__ import annotations

import math
from collections.abc import Sequence


class Barrier:
    """
    Collects, for one tick k, the packets of every vehicle in k and every vehicle's state at k + 1.

    Vehicles are counted from 0. Before the first tick (k = -1) only states are expected.
    """

    def __init__(self, count: int) -> None:
        self.tick = -1
        self._present = count
        self._missing = count
        # Tick of the last answer of each vehicle; infinity once it is lost.
        self._outbox_ticks: list[float] = [-1] * count
        self._state_ticks: list[float] = [-1] * count

    @property
    def complete(self) -> bool:
        """Whether all have answered."""
        return self._missing == 0

    def owed(self) -> list[tuple[str, int]]:
        """
        Return the nodes that have not answered, as ('agent_node' or 'vehicle_node', vehicle).

        A vehicle cannot answer before its agent has commanded it, so if both have not answered only the
        agent is named.
        """
        agents = self._outboxes_owed()
        vehicles = [vehicle for vehicle in self._states_owed() if vehicle not in agents]
        return [("agent_node", agent) for agent in agents] + [("vehicle_node", each) for each in vehicles]

    def state(self, vehicle: int, tick: int) -> bool:
        """Note the state of a vehicle at a tick; return whether it was expected."""
        if tick != self.tick + 1 or self._state_ticks[vehicle] >= tick:
            return False
        self._state_ticks[vehicle] = tick
        self._missing -= 1
        return True

    def outbox(self, vehicle: int, tick: int) -> bool:
        """Note the packets of a vehicle in a tick; return whether they were expected."""
        if tick != self.tick or self._outbox_ticks[vehicle] >= tick:
            return False
        self._outbox_ticks[vehicle] = tick
        self._missing -= 1
        return True

    def advance(self) -> int:
        """Begin the next tick and return it."""
        self.tick += 1
        self._missing = 2 * self._present
        return self.tick

    def drop(self, vehicles: Sequence[int]) -> None:
        """Continue without these vehicles."""
        for vehicle in vehicles:
            self._outbox_ticks[vehicle] = self._state_ticks[vehicle] = math.inf
        self._present = sum(tick < math.inf for tick in self._state_ticks)
        self._missing = len(self._outboxes_owed()) + len(self._states_owed())

    def _outboxes_owed(self) -> list[int]:
        return [vehicle for vehicle, tick in enumerate(self._outbox_ticks) if tick < self.tick]

    def _states_owed(self) -> list[int]:
        return [vehicle for vehicle, tick in enumerate(self._state_ticks) if tick <= self.tick]
