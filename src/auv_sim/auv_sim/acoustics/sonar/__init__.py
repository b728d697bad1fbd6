"""
Sonar: a vehicle's detection of other hulls and of obstacles, without packets.

To add one, write one file with ``Params`` and ``Sonar(params, seed)``, a `HullSonar`.  The file's name is its
``kind``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from auv_core.contracts import class_of, fulfilled
from auv_core.geometry import Vec3
from auv_core.messages import SonarContact, VehicleState
from auv_core.params import Section


class HullSonar(Protocol):
    """The sonars of a fleet."""

    def contacts(
        self,
        address: int,
        tick: int,
        period_s: float,
        states: Sequence[VehicleState],
        obstacles: Sequence[Vec3] = (),
    ) -> tuple[SonarContact, ...]:
        """
        Return the contacts of the vehicle with this address, () in a tick without a ping.

        `states` are the truth, in the order of addresses, and `obstacles` the true positions of the obstacles
        (m; NED). A contact has no identity and does not tell a hull from an obstacle, so the order of
        contacts must not reveal one. Random numbers come from `auv_sim.streams` by observer, target and tick,
        so that another vehicle or obstacle does not change them.
        """


def make_sonar(section: Section, seed: int) -> HullSonar:
    """Return the sonars of a section."""
    sonar: HullSonar = fulfilled(class_of(__name__, section.kind, "Sonar")(section.params, seed), HullSonar)
    return sonar
