"""Modems without vehicles: each modem that may transmit gets the next packet."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Sequence

from auv_core.geometry import Vec3
from auv_core.messages import AcousticEvent, Packet, VehicleState
from auv_sim.acoustics.medium import AcousticMedium

PositionsAt = Callable[[int], Sequence[Vec3]]


def talk(
    medium: AcousticMedium,
    ticks: range,
    positions_at: PositionsAt,
    *,
    payload_bytes: int = 32,
    talkers: Collection[int] | None = None,
    made: dict[tuple[int, int], int] | None = None,
) -> list[AcousticEvent]:
    """
    Let modems transmit for some ticks, and return the acoustic log.

    Parameters
    ----------
    medium : AcousticMedium
        The medium; packets on their way continue.
    ticks : range
        The ticks to run.
    positions_at : callable of int
        Positions of all modems (m; NED) at a tick, in the order of addresses.
    payload_bytes : int
        Size of every packet; all are broadcast.
    talkers : collection of int, optional
        Addresses of the modems that transmit; by default all.
    made : dict, optional
        Filled with the tick in which each packet was made, by (source, sequence).

    """
    sequences: Counter[int] = Counter()
    made = {} if made is None else made
    payload = bytes(payload_bytes)
    events: list[AcousticEvent] = []
    for tick in ticks:
        states = at_rest(tick, positions_at(tick))
        handed_over = {}
        for address, inbox in enumerate(medium.exchange(tick, states), start=1):
            if inbox.transmit_ready and (talkers is None or address in talkers):
                sequences[address] += 1
                made[address, sequences[address]] = tick
                handed_over[address] = [Packet(tick, address, 0, sequences[address], payload)]
        if handed_over:
            medium.transmit(handed_over, states)
        events += medium.take_events()
    return events


def at_rest(tick: int, positions: Sequence[Vec3]) -> list[VehicleState]:
    """Return the states of vehicles that rest, level and heading north, at positions (m; NED)."""
    nu = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return [VehicleState(tick, position, (1.0, 0.0, 0.0, 0.0), nu) for position in positions]
