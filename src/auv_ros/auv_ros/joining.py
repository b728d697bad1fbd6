"""
The offset of this machine's wall clock from that of a run, from the run's status.

A status contains a scenario time that the run has reached. When it arrives, the run is at that time or
later, by a part of a tick and the delay of the message. If the own clock, relative to the epoch, agrees with
this, it is used as the run's clock. If not, either the clock has an offset or the message was late. One
message cannot distinguish the two, and a node that follows a late message stays late. Therefore statuses are
collected for `JOIN_S`, and the least delayed one counts. Offsets below `JOIN_LIMIT_S` cannot be distinguished
from delays on a busy machine; the clocks are then synchronised well enough. Before tick 1 a status does not
tell how near the start is: a node that starts to listen then, and did not receive the status of the waiting
run, may be off by a further `START_LEAD_S`, since the nodes of a launched run must begin at tick 0. The
method uses only the own clock and the messages, so it does not matter whether the nodes are on one machine.
"""

from __future__ import annotations

import math

from auv_ros.run_config import START_LEAD_S

JOIN_LIMIT_S = 0.2
"""Delay of messages on a busy machine (s)."""
JOIN_S = 1.0
"""How long statuses are collected if the own clock does not agree with them (s)."""
LOOK_S = 0.2
"""Time between two statuses without changes (s)."""
_TOLERANCE_S = 0.02


class Joining:
    """
    Compares the own clock with the statuses of a run.

    Parameters
    ----------
    period_s : float
        Control period (s).

    """

    def __init__(self, period_s: float) -> None:
        self._limit_s = JOIN_LIMIT_S + period_s
        self._has_waited = False
        self._repeats = 0
        self._since_s = math.nan
        self._off_s = math.inf

    def wait(self) -> None:
        """Note that the run has not begun yet."""
        self._has_waited = True

    def hear(self, time_s: float, own_s: float, steady_s: float) -> float | None:
        """
        Note that the run is at a tick.

        Parameters
        ----------
        time_s : float
            Scenario time of the tick (s); 0 also for `START_LEAD_S` before tick 0.
        own_s : float
            Scenario time by the own wall clock and the epoch of the run (s).
        steady_s : float
            The steady clock (s).

        Returns
        -------
        off_s : float, optional
            Offset of the own clock (s), 0 if it agrees; None until it is known.

        """
        limit_s = self._limit_s
        if time_s <= 0.0:
            time_s = LOOK_S * max(self._repeats - 1, 0) - START_LEAD_S
            self._repeats += 1
            if not self._has_waited:
                limit_s += START_LEAD_S
        if math.isnan(self._since_s):
            self._since_s = steady_s
        off_s = own_s - time_s
        self._off_s = min(self._off_s, off_s)
        if -_TOLERANCE_S <= off_s <= limit_s:
            return 0.0
        return self._off_s if steady_s - self._since_s >= JOIN_S else None
