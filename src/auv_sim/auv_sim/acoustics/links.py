"""Counters of the packets on each link."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, field

from auv_core.messages import Outcome

# From a short travel time within a flock to a slow modem that waited for the channel (s).
DELAY_EDGES_S = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)

_LOSSES = {
    Outcome.RANGE: "lost_range",
    Outcome.NOISE: "lost_noise",
    Outcome.COLLISION: "lost_collision",
    Outcome.HALF_DUPLEX: "lost_half_duplex",
    Outcome.OUTAGE: "lost_outage",
}


@dataclass
class LinkCounters:
    """
    Counters of the packets from one modem to another.

    `delay_counts` is a histogram of the delays from the start of a transmission to the end of its reception
    over `DELAY_EDGES_S`: one bin below the first edge, and one bin starting at each edge. Packets in `sent`
    that are in no other counter are still on their way.
    """

    sent: int = 0
    delivered: int = 0
    lost_range: int = 0
    lost_noise: int = 0
    lost_collision: int = 0
    lost_half_duplex: int = 0
    lost_outage: int = 0
    bytes_sent: int = 0
    delay_counts: list[int] = field(default_factory=lambda: [0] * (len(DELAY_EDGES_S) + 1))

    @property
    def lost(self) -> int:
        """Number of packets lost, whatever the cause."""
        return sum(getattr(self, name) for name in _LOSSES.values())

    def numbers(self) -> tuple[int, ...]:
        """Return all counters except the delay histogram, in their order."""
        return (
            self.sent, self.delivered, self.lost_range, self.lost_noise, self.lost_collision,
            self.lost_half_duplex, self.lost_outage, self.bytes_sent,
        )  # fmt: skip

    def count_sent(self, size_bytes: int) -> None:
        """Count a packet that went on the air."""
        self.sent += 1
        self.bytes_sent += size_bytes

    def count_end(self, outcome: Outcome, delay_s: float) -> None:
        """Count the outcome of a packet; `delay_s` is the delay if it was delivered."""
        if outcome is Outcome.DELIVERED:
            self.delivered += 1
            # A delay that equals an edge, up to rounding, belongs to the bin that starts there.
            self.delay_counts[bisect_left(DELAY_EDGES_S, delay_s + 1e-9)] += 1
        else:
            name = _LOSSES[outcome]
            setattr(self, name, getattr(self, name) + 1)
