"""
Navigation: a vehicle's estimate of its own motion.

To add one, write one file with ``Params`` and ``Navigation(params, seed, address, period_s)``, an
`OwnNavigation`. The file's name is its ``kind``. Its only inputs are the truth of the current and of earlier
ticks; randomness comes from `auv_sim.streams`.
"""

from __future__ import annotations

from typing import Protocol

from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Vec3
from auv_core.messages import VehicleState
from auv_core.odom_frame import OdomFrame
from auv_core.params import Section


class OwnNavigation(Protocol):
    """
    The navigation of one vehicle.

    It also has, for ``odom`` and ``/tf``: `odom_frame`, which absorbs the jumps of the estimate,
    `depth_sd_m`, and `velocity_sd_mps` along the body's three axes.
    """

    odom_frame: OdomFrame
    depth_sd_m: float
    velocity_sd_mps: Vec3

    def measured(self, state: VehicleState) -> VehicleState:
        """
        Return the navigation for the true `state`; called once per control period.

        It has the standard deviations that the navigation states of itself and `is_bounded`, and `is_valid`
        is false if it has no solution.
        """


def make_navigation(section: Section, seed: int, address: int, period_s: float) -> OwnNavigation:
    """Return the navigation of a section for the vehicle with this address."""
    made = class_of(__name__, section.kind, "Navigation")(section.params, seed, address, period_s)
    navigation: OwnNavigation = fulfilled(made, OwnNavigation)
    return navigation
