"""Time-division multiple access: slots in turn, one modem each, all clocks the same."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.params import param
from auv_sim.acoustics.mac import CyclicAccess
from auv_sim.acoustics.mac._slots import check_slot


@dataclass(frozen=True)
class Params:
    """Length of a slot; a cycle has one slot per modem."""

    slot_s: float = param("length of a slot (s), airtime and guard together", default=0.25, above=0.0)


class Mac(CyclicAccess):
    """
    Modem a of n owns the slots m with m mod n = a - 1; slot m starts at m slot_s.

    The rest of a slot after a transmission is a guard time: no two packets overlap at any receiver if travel
    times differ by less than that.
    """

    def __init__(self, params: Params, fleet_size: int, seed: int) -> None:
        del seed
        self._slot_s = params.slot_s
        self.cycle_s = params.slot_s * fleet_size

    def opportunity_s(self, address: int, tick: int, period_s: float) -> float | None:
        """Return the start (s) of the first own slot that begins in the control period, or None."""
        cycle_s = self.cycle_s
        offset_s = self._slot_s * (address - 1)
        #  A nanosecond of tolerance, so that a slot that begins on a tick belongs to that tick despite
        # rounding.
        cycle = math.ceil((tick * period_s - offset_s - 1e-9) / cycle_s)
        start_s = max(cycle, 0) * cycle_s + offset_s
        return start_s if start_s < (tick + 1) * period_s - 1e-9 else None

    def check(self, airtime_s: float) -> None:
        """Raise ValueError if a transmission is longer than the slot."""
        check_slot(self._slot_s, airtime_s)
