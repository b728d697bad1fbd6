"""
How far this machine's wall clock is ahead of that of a run, by what the run's status says.

A status tells a scenario time that the run has reached. When it arrives the run is there or further, by a
part of a tick and by the time that the message took. The own clock, read against the epoch, is taken for the
run's where it says just that. Where it does not, either it is off or the message was late; both look alike in
one message, and a node that follows a late one stays late. So statuses are heard for `JOIN_S`, and the one
that was least late counts. Offsets below `JOIN_LIMIT_S` cannot be told from what ticks and messages take on a
busy machine: clocks are then synchronised as well as inputs need it. Until tick 1 a status does not tell how
near the start is: a node that begins to listen just then and did not hear the run wait may be off by
`START_LEAD_S` more, since the nodes of a launched run must begin at tick 0. It makes no difference whether
the nodes are on one machine: only the own clock and the messages are asked.
"""

from __future__ import annotations

import math

from auv_ros.run_config import START_LEAD_S

JOIN_LIMIT_S = 0.2
"""What messages take, on a busy machine (s)."""
JOIN_S = 1.0
"""How long statuses are heard where the own clock does not fit them (s)."""
LOOK_S = 0.2
"""Time between two statuses of a clock that has no news (s)."""
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
        """Hear that the run has not begun yet."""
        self._has_waited = True

    def hear(self, time_s: float, own_s: float, steady_s: float) -> float | None:
        """
        Hear that the run is at a tick.

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
            How far the own clock is ahead (s), 0 where it fits; nothing as long as that is not known.

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
