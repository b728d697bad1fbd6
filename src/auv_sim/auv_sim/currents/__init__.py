"""
Currents: how the velocity of the water at a vehicle varies about the scenario's mean.

To add one, write one file with ``Params`` and ``Current(params, mean_ned_mps, seed, address, period_s)``, a
`WaterCurrent`. The file's name is its ``kind``. Randomness comes from `auv_sim.streams`.
"""

from __future__ import annotations

from typing import Protocol

from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Vec3
from auv_core.params import Section


class WaterCurrent(Protocol):
    """
    The water at one vehicle. It depends on time alone.

    It also has `varies_by_mps`: a speed by which the water seldom differs from its mean (m/s), three standard
    deviations; 0 if it is steady.
    """

    varies_by_mps: float

    def at(self, tick: int) -> Vec3:
        """Return the velocity of the water (m/s; NED) in the control period that begins at `tick`."""


def make_current(
    section: Section, mean_ned_mps: Vec3, seed: int, address: int, period_s: float
) -> WaterCurrent:
    """Return the current of a section at the vehicle with this address."""
    current_class = class_of(__name__, section.kind, "Current")
    made = current_class(section.params, mean_ned_mps, seed, address, period_s)
    current: WaterCurrent = fulfilled(made, WaterCurrent)
    return current
