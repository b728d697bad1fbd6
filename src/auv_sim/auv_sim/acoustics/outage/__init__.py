"""
Outage: losses that no model of range or noise explains.

To add one, write one file with ``Params`` and ``Outage(params, seed)``, a `PacketLoss`.
"""

from __future__ import annotations

from typing import Protocol

from auv_core.contracts import class_of, fulfilled
from auv_core.params import Section


class PacketLoss(Protocol):
    """Further random losses."""

    def lost(self, source: int, destination: int, sequence: int) -> bool:
        """
        Return whether a packet is lost on the way to a modem.

        The result depends only on the seed and these three, so that adding a vehicle does not change the
        losses of the others; `auv_sim.streams.uniform` gives the numbers.
        """


def make_outage(section: Section, seed: int) -> PacketLoss:
    """Return the losses of a section."""
    outage: PacketLoss = fulfilled(
        class_of(__name__, section.kind, "Outage")(section.params, seed), PacketLoss
    )
    return outage
