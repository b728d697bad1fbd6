"""A modem without limits: no airtime, any range, any length."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_sim.acoustics.modem import AcousticModem


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


class Modem(AcousticModem):
    """Every packet fits and takes no time, so that packets never overlap."""

    max_range_m = math.inf
    max_payload_bytes = 65535
    preamble_s = 0.0
    captures = True

    def __init__(self, params: Params) -> None:
        del params

    def airtime_s(self, payload_bytes: int) -> float:
        """Return 0 s."""
        del payload_bytes
        return 0.0
