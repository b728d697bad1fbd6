"""
Medium access: when a modem asks its vehicle for data, and when it transmits them.

To add one, write one file with ``Params`` and ``Mac(params, fleet_size, seed)``, a `MediumAccess`, or a
`SensingAccess` if the modem listens before it transmits. A modem that is transmitting, or has a packet, does
not ask. Random numbers come from `auv_sim.streams` and depend only on the seed, the address, and the slot or
packet.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from auv_core.contracts import class_of, fulfilled
from auv_core.params import Section


class MediumAccess(Protocol):
    """When the modems of a fleet may transmit."""

    def opportunity_s(self, address: int, tick: int, period_s: float) -> float | None:
        """
        Return when a modem would begin a transmission (s), or None; repeated calls give the same result.

        It is the first such time in the control period [tick, tick + 1).
        """

    def check(self, airtime_s: float) -> None:
        """
        Accept transmissions of a length (s).

        Raises
        ------
        ValueError
            With a message ``field: ...``, if the length does not fit the scheme.

        """


@runtime_checkable
class SensingAccess(MediumAccess, Protocol):
    """A modem that listens at that time and keeps the packet while it hears a signal."""

    def backoff_s(self, source: int, sequence: int, attempt: int) -> float:
        """Return the wait (s, above zero) before it listens again; the first attempt is 1."""


@runtime_checkable
class CyclicAccess(MediumAccess, Protocol):
    """Medium access in which every modem has its turn once per cycle, which lasts `cycle_s` (s)."""

    cycle_s: float


def make_mac(section: Section, fleet_size: int, seed: int) -> MediumAccess:
    """Return the medium access of a section."""
    made = class_of(__name__, section.kind, "Mac")(section.params, fleet_size, seed)
    mac: MediumAccess = fulfilled(made, MediumAccess)
    return mac
