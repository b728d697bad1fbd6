"""Losses in bursts: every link is in a good or a bad state, which may change from packet to packet."""

from __future__ import annotations

import math
from dataclasses import dataclass

from auv_core.params import param
from auv_sim.acoustics.outage import PacketLoss
from auv_sim.streams import Purpose, uniform


@dataclass(frozen=True)
class Params:
    """Transitions per packet, and the loss in each state."""

    p_gb: float = param(
        "probability that a good link is bad at the next packet", default=0.05, minimum=1e-4, maximum=1.0
    )
    p_bg: float = param(
        "probability that a bad link is good at the next packet", default=0.25, minimum=1e-4, maximum=1.0
    )
    loss_good_prob: float = param(
        "probability of a loss in the good state", default=0.02, minimum=0.0, maximum=1.0
    )
    loss_bad_prob: float = param(
        "probability of a loss in the bad state", default=0.8, minimum=0.0, maximum=1.0
    )

    def __post_init__(self) -> None:
        """Refuse a chain that is more likely to change than to stay: it has no bursts."""
        if self.p_gb + self.p_bg > 1.0:
            raise ValueError(
                f"p_gb: {self.p_gb!r} is not allowed; allowed: at most 1 - p_bg = {1.0 - self.p_bg:g}"
            )

    @property
    def loss_prob(self) -> float:
        """Share of packets lost in the long run."""
        bad = self.p_gb / (self.p_gb + self.p_bg)
        return (1.0 - bad) * self.loss_good_prob + bad * self.loss_bad_prob


class Outage(PacketLoss):
    """
    A chain of two states per link, Gilbert (1960) and Elliott (1963).

    With s = p_gb + p_bg <= 1 the chain is equivalent to this one: at every packet the state is drawn again
    with probability s, bad with probability p_gb / s, and stays otherwise. So the state at a packet is that
    of the last new draw, and depends on the link and the sequence number only, not on earlier calls.
    """

    def __init__(self, params: Params, seed: int) -> None:
        self._params = params
        self._seed = seed
        self._fresh_prob = params.p_gb + params.p_bg
        # The last new draw is not farther back than this, except with a probability of 1e-20.
        self._memory = math.ceil(50.0 / self._fresh_prob)
        self._known: dict[tuple[int, int], tuple[int, bool]] = {}

    def lost(self, source: int, destination: int, sequence: int) -> bool:
        """Return whether the reception at `destination` fails."""
        is_bad = self.is_bad(source, destination, sequence)
        loss_prob = self._params.loss_bad_prob if is_bad else self._params.loss_good_prob
        return uniform(self._seed, Purpose.OUTAGE, source, destination, sequence) < loss_prob

    def is_bad(self, source: int, destination: int, sequence: int) -> bool:
        """Return whether the link is in its bad state at this packet."""
        link = (source, destination)
        fresh, share = self._fresh_prob, self._params.p_gb / self._fresh_prob
        known, state = self._known.get(link, (-1, False))
        first = max(sequence - self._memory, 0)
        for earlier in range(sequence, first - 1, -1):
            if earlier == known:
                break
            u = uniform(self._seed, Purpose.BURST, source, destination, earlier)
            if u < fresh:
                state = u / fresh < share
                break
            if earlier == first:
                state = (u - fresh) / (1.0 - fresh) < share
        self._known[link] = (sequence, state)
        return state
