"""The relay in real time: ticks begin by the steady clock, with the newest state of every vehicle."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from auv_core.messages import Packet, VehicleState
from auv_sim.relay import Water
from auv_sim.relay.silences import Silences
from auv_sim.relay.state_watch import StateWatch


class SteadyTicks(Protocol):
    """The steady clock of a run, in ticks."""

    def tick_now(self) -> int:
        """Return the current tick."""

    def tick_now_or(self, tick: int) -> int:
        """Return the current tick, or the given one until scenario time 0 is known."""


class RealTimeRelay:
    """
    A `Relay` in real time. Packets are sent when they come, if the position of the modem is known.

    Parameters
    ----------
    water : Water
        Where packets go.
    states, silences : StateWatch, Silences
        The limits of age and of silence.
    ticks, steady_s : SteadyTicks, callable
        The steady clock in ticks, and in seconds.
    may_begin : callable
        Returns whether the run allows a further tick now.

    Attributes
    ----------
    tick : int
        The current tick.
    lost : list of int
        The lost vehicles.

    """

    def __init__(
        self,
        water: Water,
        states: StateWatch,
        silences: Silences,
        ticks: SteadyTicks,
        steady_s: Callable[[], float],
        may_begin: Callable[[], bool],
    ) -> None:
        self._water = water
        self._watch = states
        self._silences = silences
        self._ticks = ticks
        self._steady_s = steady_s
        self._may_begin = may_begin
        self._newest: dict[int, VehicleState] = {}
        self.tick = -1
        self.lost: list[int] = []

    def hear_state(self, vehicle: int, state: VehicleState) -> None:
        """Take a state of a vehicle, unless it is lost."""
        if vehicle in self.lost:
            return
        self._silences.hear("vehicle_node", vehicle, self._steady_s())
        if self._watch.hear(vehicle, state, self._ticks.tick_now_or(state.tick)):
            self._newest[vehicle] = state

    def hear_packets(self, vehicle: int, tick: int, packets: list[Packet]) -> None:
        """Send packets of a vehicle."""
        self._silences.hear("agent_node", vehicle, self._steady_s())
        if self._all_known and self._watch.may_send(vehicle, self._ticks.tick_now(), len(packets)):
            self._water.transmit(vehicle, packets, self._fleet())

    def advance(self) -> bool:
        """Begin the tick of the steady clock, if it is new; return whether it has begun."""
        tick = self._ticks.tick_now()
        if tick <= self.tick or not self._all_known or not self._may_begin():
            return False
        if self.tick < 0:
            self._silences.begin(self._steady_s())
        for vehicle in self.lost:
            self._newest[vehicle] = self._water.drift(vehicle)
        self.tick = tick
        self._water.begin_tick(tick, self._fleet())
        return True

    def owed(self) -> list[tuple[str, int]]:
        """Return the nodes that are silent, before the first tick those of vehicles without a state."""
        if self.tick < 0:
            return [
                ("vehicle_node", vehicle) for vehicle in self._watch.vehicles if vehicle not in self._newest
            ]
        return self._silences.silent(self._steady_s(), without=self.lost)

    def drop(self) -> list[int]:
        """Continue without the vehicles whose nodes are silent, and return them."""
        vehicles = sorted({vehicle for _, vehicle in self.owed()})
        for vehicle in vehicles:
            self._water.lose(vehicle, self._newest[vehicle])
        self.lost += vehicles
        return vehicles

    @property
    def _all_known(self) -> bool:
        return len(self._newest) == len(self._watch.vehicles)

    def _fleet(self) -> list[VehicleState]:
        return [self._newest[vehicle] for vehicle in self._watch.vehicles]
