"""Unslotted ALOHA: a modem transmits when it has data, whatever the others do."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.params import param
from auv_sim.acoustics.mac import MediumAccess
from auv_sim.acoustics.mac._poisson import PoissonTimes


@dataclass(frozen=True)
class Params:
    """How often a modem has data."""

    mean_interval_s: float = param(
        "mean time between a modem's transmissions (s); they are a Poisson process", default=2.0, minimum=1e-3
    )


class Mac(MediumAccess):
    """A transmission starts at the random time, unless the modem is still on the air with the last one."""

    def __init__(self, params: Params, fleet_size: int, seed: int) -> None:
        del fleet_size
        self._times = PoissonTimes(params.mean_interval_s, seed)

    def opportunity_s(self, address: int, tick: int, period_s: float) -> float | None:
        """Return the first random time (s) in the control period, or None."""
        return self._times.first_s(address, tick * period_s, (tick + 1) * period_s)

    def check(self, airtime_s: float) -> None:
        """Accept every length."""
        del airtime_s
