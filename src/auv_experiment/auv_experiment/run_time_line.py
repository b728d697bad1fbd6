"""The time line of a recorded run: which tick a message is of, and whether the run has it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from contextlib import suppress
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from auv_bag.bag import Bag
from auv_bag.writer import BagError

Flags = NDArray[np.bool_]
IntArray = NDArray[np.int64]

_MORE_TICKS = 1000
"""Number of ticks that a run in real time can have before and after its own: it ends when it wakes up."""
_EPOCH_STATES = 1000


class RunTimeLine:
    """
    Ticks of a run, and the stamps that they have in its bag.

    Parameters
    ----------
    bag : Bag
        The bag, for the stamp of tick 0, which is wall time in a run in real time.
    vehicle_ids : sequence of str
        Vehicles whose states give this stamp.
    period_s : float
        Control period (s).
    most_ticks : int
        Length of the run.

    """

    def __init__(self, bag: Bag, vehicle_ids: Sequence[str], period_s: float, most_ticks: int) -> None:
        self._period_s = period_s
        self._last_tick = most_ticks + _MORE_TICKS
        self._epoch_ns = self._find_epoch_ns(bag, vehicle_ids)

    def has(self, ticks: IntArray) -> Flags:
        """Return which ticks are valid for the run."""
        flags: Flags = (ticks >= -_MORE_TICKS) & (ticks <= self._last_tick)
        return flags

    def ticks(self, stamp: Any) -> IntArray:
        """Return the ticks of stamps."""
        ticks: IntArray = np.rint(self.scenario_s(stamp) / self._period_s).astype(np.int64)
        return ticks

    def scenario_s(self, stamp: Any) -> NDArray[np.float64]:
        """Return the scenario times of stamps (s)."""
        return seconds(nanoseconds(stamp) - self._epoch_ns)

    def lateness_ns(self, ticks: IntArray, stamp: Any) -> IntArray:
        """Return the delay of stamps relative to their ticks (ns)."""
        return nanoseconds(stamp) - self._epoch_ns - self._since_epoch_ns(ticks)

    def _since_epoch_ns(self, ticks: Any) -> Any:
        return np.rint(ticks * self._period_s * 1e9).astype(np.int64)

    def _find_epoch_ns(self, bag: Bag, vehicle_ids: Sequence[str]) -> int:
        """
        Return the stamp of tick 0 (ns).

        It is the value from most of the first states, since some may come from a foreign process, and older
        runs in real time stamped tick 0 with 0.
        """
        epochs_ns: defaultdict[int, dict[tuple[str, int], int]] = defaultdict(dict)
        for message in islice(bag.messages({f"/{name}/state" for name in vehicle_ids}), _EPOCH_STATES):
            with suppress(BagError):
                state = bag.decode(message)
                epoch_ns = int(nanoseconds(state.header.stamp)) - round(state.tick * self._period_s * 1e9)
                epochs_ns[round(epoch_ns * 1e-6)][message.topic, state.tick] = epoch_ns
        likeliest = max(epochs_ns.values(), key=len, default={})
        return next(reversed(likeliest.values()), 0)


def nanoseconds(stamp: Any) -> IntArray:
    """Return stamps as whole nanoseconds."""
    whole: IntArray = np.asarray(stamp.sec, np.int64) * 1_000_000_000 + stamp.nanosec
    return whole


def seconds(times_ns: IntArray) -> NDArray[np.float64]:
    """Return times in nanoseconds as seconds."""
    return times_ns.astype(np.float64) * 1e-9
