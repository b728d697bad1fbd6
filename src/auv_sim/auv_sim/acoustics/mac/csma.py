"""Carrier-sense multiple access: as ALOHA, but a modem that hears a signal waits and listens again."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.params import param
from auv_sim.acoustics.mac import SensingAccess
from auv_sim.acoustics.mac._poisson import PoissonTimes
from auv_sim.streams import Purpose, uniform


@dataclass(frozen=True)
class Params:
    """How often a modem has data, and how long it waits if the channel is busy."""

    mean_interval_s: float = param(
        "mean time between a modem's requests to transmit (s); they are a Poisson process",
        default=2.0,
        minimum=1e-3,
    )
    min_backoff_s: float = param("shortest wait (s)", default=0.05, minimum=1e-3)
    max_backoff_s: float = param(
        "longest wait (s) after the first busy channel; it doubles each time, up to 8 times",
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


class Mac(SensingAccess):
    """
    Non-persistent, with binary exponential backoff of at most three doublings.

    A quiet channel is no guarantee: a signal may still be on its way, and the receiver may hear signals that
    do not reach this modem.
    """

    def __init__(self, params: Params, fleet_size: int, seed: int) -> None:
        del fleet_size
        self._params = params
        self._seed = seed
        self._times = PoissonTimes(params.mean_interval_s, seed)

    def opportunity_s(self, address: int, tick: int, period_s: float) -> float | None:
        """Return the first random time (s) in the control period, or None."""
        return self._times.first_s(address, tick * period_s, (tick + 1) * period_s)

    def backoff_s(self, source: int, sequence: int, attempt: int) -> float:
        """Return the wait (s) after the channel was busy for the `attempt`-th time, from 1."""
        low_s = self._params.min_backoff_s
        high_s = self._params.max_backoff_s * 2 ** min(attempt - 1, 3)
        return low_s + (high_s - low_s) * uniform(self._seed, Purpose.MAC, source, attempt, sequence)

    def check(self, airtime_s: float) -> None:
        """Accept every length."""
        del airtime_s
