"""Independent losses: every packet on every link is lost with the same probability."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.params import param
from auv_sim.acoustics.outage import PacketLoss
from auv_sim.streams import Purpose, uniform


@dataclass(frozen=True)
class Params:
    """How often a reception fails."""

    loss_prob: float = param("probability that one reception is lost", default=0.2, minimum=0.0, maximum=1.0)


class Outage(PacketLoss):
    """One random number per (source, destination, sequence)."""

    def __init__(self, params: Params, seed: int) -> None:
        self._loss_prob = params.loss_prob
        self._seed = seed

    def lost(self, source: int, destination: int, sequence: int) -> bool:
        """Return whether the reception at `destination` fails."""
        return uniform(self._seed, Purpose.OUTAGE, source, destination, sequence) < self._loss_prob
