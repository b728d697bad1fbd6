"""The relay in lock-step: a tick begins when every agent and every vehicle has answered for the last one."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from auv_core.messages import Packet, VehicleState
from auv_sim.relay import Water
from auv_sim.relay.barrier import Barrier


class LockStepRelay:
    """
    A `Relay` in lock-step. Packets wait until the tick is complete, so that their order is always the same.

    Parameters
    ----------
    count : int
        Number of vehicles.
    water : Water
        Where packets go.
    may_begin : callable
        Returns whether the run allows a further tick now.

    """

    def __init__(self, count: int, water: Water, may_begin: Callable[[], bool]) -> None:
        self._water = water
        self._may_begin = may_begin
        self._barrier = Barrier(count)
        self._states: Sequence[VehicleState] = []
        self._next_states: dict[int, VehicleState] = {}
        self._packets: dict[int, list[Packet]] = {}
        self.lost: list[int] = []

    @property
    def tick(self) -> int:
        """The current tick."""
        return self._barrier.tick

    def hear_state(self, vehicle: int, state: VehicleState) -> None:
        """Take the state of a vehicle at the next tick; others are ignored."""
        if self._barrier.state(vehicle, state.tick):
            self._next_states[vehicle] = state
            self.advance()

    def hear_packets(self, vehicle: int, tick: int, packets: list[Packet]) -> None:
        """Take the packets of a vehicle in the current tick; others are ignored."""
        if self._barrier.outbox(vehicle, tick):
            self._packets[vehicle] = packets
            self.advance()

    def advance(self) -> bool:
        """Begin the next tick if all have answered; return whether it has begun."""
        if not self._barrier.complete or not self._may_begin():
            return False
        for vehicle, packets in sorted(self._packets.items()):
            self._water.transmit(vehicle, packets, self._states)
        self._states = [state for _, state in sorted(self._next_states.items())]
        self._packets, self._next_states = {}, {}
        if self._water.begin_tick(self._barrier.advance(), self._states):
            for vehicle in self.lost:
                self._next_states[vehicle] = self._water.drift(vehicle)
        return True

    def owed(self) -> list[tuple[str, int]]:
        """Return the nodes that have not answered, as (role, vehicle)."""
        return self._barrier.owed()

    def drop(self) -> list[int]:
        """Continue without the vehicles whose nodes have not answered, and return them."""
        vehicles = sorted({vehicle for _, vehicle in self.owed()})
        for vehicle in vehicles:
            answer = self._next_states.get(vehicle)
            self._water.lose(vehicle, answer or self._states[vehicle])
            self._next_states[vehicle] = answer or self._water.drift(vehicle)
        self._barrier.drop(vehicles)
        self.lost += vehicles
        return vehicles
