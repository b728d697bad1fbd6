"""No sonar."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from auv_core.geometry import Vec3
from auv_core.messages import SonarContact, VehicleState
from auv_sim.acoustics.sonar import HullSonar


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


class Sonar(HullSonar):
    """Nothing is seen."""

    def __init__(self, params: Params, seed: int) -> None:
        del params, seed

    def contacts(
        self,
        address: int,
        tick: int,
        period_s: float,
        states: Sequence[VehicleState],
        obstacles: Sequence[Vec3] = (),
    ) -> tuple[SonarContact, ...]:
        """Return no contact."""
        del address, tick, period_s, states, obstacles
        return ()
