"""Carrier-sense multiple access: as ALOHA, but a modem that hears something waits and listens again."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.params import param
from auv_sim.acoustics.mac._poisson import PoissonTimes
from auv_sim.streams import Purpose, uniform


@dataclass(frozen=True)
class Params:
    """How often there is something to say, and how long to wait when the water is not quiet."""

    mean_interval_s: float = param(
        "mean time between a modem's wishes to transmit (s); they are a Poisson process",
        default=2.0,
        minimum=1e-3,
    )
    min_backoff_s: float = param("shortest wait (s)", default=0.05, minimum=1e-3)
    max_backoff_s: float = param(
        "longest wait (s) after the first time that something is heard; it doubles each time, up to 8 times",
        default=0.5,
        minimum=1e-3,
    )

    def __post_init__(self) -> None:
        """Refuse a longest wait that is shorter than the shortest."""
        if self.max_backoff_s < self.min_backoff_s:
            raise ValueError(
                f"max_backoff_s: {self.max_backoff_s!r} is not allowed; "
                f"allowed: at least min_backoff_s = {self.min_backoff_s!r}"
            )


class Mac:
    """
    Non-persistent, with binary exponential backoff of at most three doublings.

    A quiet place is no promise: what is on its way is not heard yet, and what the receiver hears is not heard
    here.
    """

    senses = True

    def __init__(self, params: Params, fleet_size: int, seed: int) -> None:
        del fleet_size
        self._params = params
        self._seed = seed
        self._times = PoissonTimes(params.mean_interval_s, seed)

    def opportunity_s(self, address: int, tick: int, period_s: float) -> float | None:
        """Return the first random time (s) in the control period, or None."""
        return self._times.first_s(address, tick * period_s, (tick + 1) * period_s)

    def backoff_s(self, source: int, sequence: int, attempt: int) -> float:
        """Return how long (s) to wait after having heard something for the `attempt`-th time, from 1 on."""
        low_s = self._params.min_backoff_s
        high_s = self._params.max_backoff_s * 2 ** min(attempt - 1, 3)
        return low_s + (high_s - low_s) * uniform(self._seed, Purpose.MAC, source, attempt, sequence)

    def check(self, airtime_s: float) -> None:
        """Accept every length."""
        del airtime_s
