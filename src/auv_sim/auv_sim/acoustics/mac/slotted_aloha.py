"""Slotted ALOHA: in every slot each modem transmits with a fixed probability."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.params import param
from auv_sim.acoustics.mac import MediumAccess
from auv_sim.acoustics.mac._slots import check_slot
from auv_sim.streams import Purpose, uniform


@dataclass(frozen=True)
class Params:
    """Length of a slot, and how often a modem uses one."""

    slot_s: float = param("length of a slot (s), airtime and guard together", default=0.25, minimum=1e-3)
    transmit_prob: float = param(
        "probability that a modem transmits in a slot; 1 / fleet size gives the largest throughput",
        default=0.25, minimum=0.0, maximum=1.0,
    )  # fmt: skip


class Mac(MediumAccess):
    """A modem transmits at the start of a slot with that probability, by (seed, address, slot)."""

    def __init__(self, params: Params, fleet_size: int, seed: int) -> None:
        self._slot_s = params.slot_s
        del fleet_size
        self._prob = params.transmit_prob
        self._seed = seed

    def opportunity_s(self, address: int, tick: int, period_s: float) -> float | None:
        """
        Return the start (s) of the first slot of the control period in which the modem transmits, or None.
        """
        #  A nanosecond of tolerance, so that a slot that begins on a tick belongs to that tick despite
        # rounding.
        first = max(math.ceil((tick * period_s - 1e-9) / self._slot_s), 0)
        last = math.ceil(((tick + 1) * period_s - 1e-9) / self._slot_s)
        for slot in range(first, last):
            if uniform(self._seed, Purpose.MAC, address, 0, slot) < self._prob:
                return slot * self._slot_s
        return None

    def check(self, airtime_s: float) -> None:
        """Raise ValueError if a transmission is longer than the slot."""
        check_slot(self._slot_s, airtime_s)
