"""How long a run of a sweep may take before it counts as one that never ends."""

from __future__ import annotations

import math
from statistics import median

from auv_experiment.sweeps.plan import PlannedRun
from auv_experiment.sweeps.worker import Finished

LEAST_LIMIT_S = 300.0
_TIMES_THE_MEDIAN = 20.0


class Patience:
    """
    Knows what finished runs took, and from that how long another may take.

    Parameters
    ----------
    limit_s : float, optional
        The limit of every run (s, wall), whatever others took.

    """

    def __init__(self, limit_s: float | None = None) -> None:
        self._limit_s = limit_s
        self._s_per_effort: list[float] = []

    def note(self, run: PlannedRun, finished: Finished) -> None:
        """Take what came of a run; one that failed says nothing."""
        if finished.wall_s is not None:
            self._s_per_effort.append(finished.wall_s / run.effort)

    def limit_s(self, run: PlannedRun) -> float:
        """
        Return how long a run may take (s, wall).

        Without a limit that was given it is 20 times what the finished runs took, by the median and in
        proportion to the effort that is expected, and at least 300 s; as long as none has finished, no limit.
        """
        if self._limit_s is not None:
            return self._limit_s
        if not self._s_per_effort:
            return math.inf
        return max(LEAST_LIMIT_S, _TIMES_THE_MEDIAN * median(self._s_per_effort) * run.effort)
