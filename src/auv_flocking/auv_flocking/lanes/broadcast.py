"""
When a vehicle in a fleet of lanes uses its slot of the channel.

``periodic``: always. ``event``: if the path parameter differs from what receivers predict, if the mode has
changed, or after a heartbeat; and again in the next slots, since a lost packet is not noticed. The threshold
falls with time, c0 + c1 exp(-alpha (t - t0)), as in the event-triggered coordination of Farol (DSOR,
Lisbon). A vehicle on its way to its lane or back to its layer always sends.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from auv_core.params import param
from auv_flocking.lanes.status import LaneStatus, Mode

_LARGEST_EXPONENT = 50.0


@dataclass(frozen=True)
class Params:
    """Kind, thresholds, repeats and heartbeat."""

    kind: str = param(
        "whether to send in every own slot or only with news", default="event", choices=("event", "periodic")
    )
    threshold_m: float = param("threshold c0 on the path parameter (m)", default=2.0, minimum=0.0)
    threshold_early_m: float = param("additional threshold c1 at t0 (m)", default=5.0, minimum=0.0)
    threshold_rate_ps: float = param("rate alpha at which c1 falls (1/s)", default=0.02, minimum=0.0)
    threshold_from_s: float = param("time t0 of the threshold c0 + c1 (s)", default=100.0, minimum=0.0)
    repeats: int = param("repeats of a packet, in the next own slots", default=2, minimum=0, maximum=100)
    heartbeat_s: float = param("longest time without a packet (s)", default=60.0, above=0.0)

    def threshold_at_m(self, t_s: float) -> float:
        """Return the threshold at a time (m)."""
        exponent = min(self.threshold_rate_ps * (self.threshold_from_s - t_s), _LARGEST_EXPONENT)
        return self.threshold_m + self.threshold_early_m * math.exp(exponent)


class Sent(NamedTuple):
    """The last packet: its time tag (s) and its status, and the number of repeats still to send."""

    time_s: float
    status: LaneStatus
    repeats: int


def has_news(t_s: float, own: LaneStatus, ahead_m: float, sent: Sent, params: Params) -> bool:
    """
    Return whether a packet would tell receivers more than they know.

    Parameters
    ----------
    t_s : float
        Time (s).
    own : LaneStatus
        The own status.
    ahead_m : float
        The own path parameter minus what receivers predict from the last packet (m).
    sent : Sent
        The last packet.
    params : Params
        Of the broadcast.

    """
    if own.mode != sent.status.mode:
        return True
    return own.mode != Mode.LOITER and abs(ahead_m) > params.threshold_at_m(t_s)


def after_slot(
    t_s: float, own: LaneStatus, ahead_m: float, sent: Sent | None, params: Params
) -> tuple[bool, Sent | None]:
    """
    Return whether to send in an own slot, and the last packet after it.

    Arguments as of `has_news`; `sent` is None at the start. A heartbeat is not repeated.
    """
    if sent is None or has_news(t_s, own, ahead_m, sent, params):
        return True, Sent(t_s, own, params.repeats)
    if params.kind == "periodic" or own.mode in (Mode.TRANSIT, Mode.LEAVE):
        return True, Sent(t_s, own, sent.repeats)
    if sent.repeats > 0:
        return True, Sent(t_s, own, sent.repeats - 1)
    if t_s - sent.time_s >= params.heartbeat_s:
        return True, Sent(t_s, own, 0)
    return False, sent
