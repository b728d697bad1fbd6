"""Exact navigation: every vehicle knows its true state."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.messages import VehicleState
from auv_core.odom_frame import OdomFrame
from auv_sim.navigation import OwnNavigation


@dataclass(frozen=True)
class Params:
    """Nothing to choose."""


class Navigation(OwnNavigation):
    """The truth."""

    odom_frame = OdomFrame()
    depth_sd_m = 0.0
    velocity_sd_mps = (0.0, 0.0, 0.0)

    def __init__(self, params: Params, seed: int, address: int, period_s: float) -> None:
        del params, seed, address, period_s

    def measured(self, state: VehicleState) -> VehicleState:
        """Return `state` itself."""
        return state
