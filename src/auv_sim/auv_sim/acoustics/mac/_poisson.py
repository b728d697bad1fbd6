"""A Poisson process that can be queried for any interval, in any order."""

from __future__ import annotations

from auv_sim.streams import Purpose, generator


class PoissonTimes:
    """
    Random times with a mean interval, one process per address.

    Time is cut into windows of the mean interval; each has a Poisson number of times (mean 1), uniform in
    the window, from its own generator.
    """

    def __init__(self, mean_interval_s: float, seed: int) -> None:
        self._window_s = mean_interval_s
        self._seed = seed
        self._known: dict[int, tuple[int, list[float]]] = {}

    def first_s(self, address: int, begin_s: float, end_s: float) -> float | None:
        """Return the first time in [begin_s, end_s), or None."""
        for window in range(int(begin_s // self._window_s), int(end_s // self._window_s) + 1):
            for time_s in self._times_s(address, window):
                if begin_s <= time_s < end_s:
                    return time_s
        return None

    def _times_s(self, address: int, window: int) -> list[float]:
        known = self._known.get(address)
        if known is not None and known[0] == window:
            return known[1]
        rng = generator(self._seed, Purpose.MAC, address, window)
        count = int(rng.poisson(1.0))
        times_s = sorted(self._window_s * (window + float(u)) for u in rng.random(count))
        self._known[address] = (window, times_s)
        return times_s
