"""
When a relay begins a tick: in lock-step with the last answer, in real time by the clock. Without ROS.

Vehicles are counted from 0. Before the first tick, the tick is -1.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from auv_core.messages import Packet, VehicleState


class Water(Protocol):
    """The water between the vehicles, as a relay uses it."""

    def transmit(self, vehicle: int, packets: list[Packet], states: Sequence[VehicleState]) -> None:
        """Send packets of a vehicle, while the fleet is in these states."""

    def begin_tick(self, tick: int, states: Sequence[VehicleState]) -> bool:
        """Deliver the packets that arrive by a tick; return whether the run continues."""

    def lose(self, vehicle: int, state: VehicleState) -> None:
        """Let the hull of a lost vehicle drift, from this state."""

    def drift(self, vehicle: int) -> VehicleState:
        """Return the next state of a hull that drifts."""


class Relay(Protocol):
    """
    Collects the answers of a fleet, and begins ticks.

    Attributes
    ----------
    lost : list of int
        The lost vehicles.

    """

    lost: list[int]

    @property
    def tick(self) -> int:
        """The current tick."""

    def hear_state(self, vehicle: int, state: VehicleState) -> None:
        """Take a state of a vehicle."""

    def hear_packets(self, vehicle: int, tick: int, packets: list[Packet]) -> None:
        """Take the packets that a vehicle passes to its modem in a tick."""

    def advance(self) -> bool:
        """Begin the next tick, if it is time; return whether it has begun."""

    def owed(self) -> list[tuple[str, int]]:
        """Return the nodes that have not answered, as ('agent_node' or 'vehicle_node', vehicle)."""

    def drop(self) -> list[int]:
        """Continue without the vehicles whose nodes have not answered, and return them."""
