"""The duration after which a run of a sweep counts as one that never ends."""

from __future__ import annotations

import math
from statistics import median

from auv_experiment.sweeps.plan import PlannedRun
from auv_experiment.sweeps.worker import Finished

LEAST_LIMIT_S = 300.0
_TIMES_THE_MEDIAN = 20.0


class Patience:
    """
    Limits the duration of a run by the durations of finished runs.

    Parameters
    ----------
    limit_s : float, optional
        A fixed limit for every run (s, wall).

    """

    def __init__(self, limit_s: float | None = None) -> None:
        self._limit_s = limit_s
        self._s_per_effort: list[float] = []

    def note(self, run: PlannedRun, finished: Finished) -> None:
        """Note the result of a run; failed runs do not count."""
        if finished.wall_s is not None:
            self._s_per_effort.append(finished.wall_s / run.effort)

    def limit_s(self, run: PlannedRun) -> float:
        """
        Return the limit for a run (s, wall).

        Unless a fixed limit is given, it is 20 times the median duration of the finished runs, in proportion
        to the expected effort, and at least 300 s. There is no limit until a run has finished.
        """
        if self._limit_s is not None:
            return self._limit_s
        if not self._s_per_effort:
            return math.inf
        return max(LEAST_LIMIT_S, _TIMES_THE_MEDIAN * median(self._s_per_effort) * run.effort)
