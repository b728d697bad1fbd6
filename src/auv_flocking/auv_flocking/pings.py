"""
What the own sonar showed last, as directions from north: raw contacts for laws that want them.

A contact has no identity. Laws that ask where a neighbour is take its estimate, into which contacts have
gone; laws that avoid obstacles take the tracks. A ping also shows what is neither yet.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from auv_core.geometry import Vec3, body_to_ned
from auv_core.messages import SonarContact, VehicleState
from auv_flocking.neighbours.sonar_contact import contact_of, is_contact, relative_of


class Echo(NamedTuple):
    """One contact: range (m), bearing (rad; from north to east) and elevation (rad; positive up)."""

    range_m: float
    bearing_rad: float
    elevation_rad: float

    @property
    def relative_ned_m(self) -> Vec3:
        """Where it is from the own vehicle (m; NED)."""
        return relative_of(SonarContact(*self))


class Ping(NamedTuple):
    """
    The newest ping that showed something.

    echoes : its plausible contacts, in the order of the sonar. age_s : time since it (s; inf: there was
    none). The vehicle has moved since, and turns do not matter.
    """

    echoes: tuple[Echo, ...] = ()
    age_s: float = math.inf


NO_PING = Ping()


def echoes_of(nav: VehicleState, contacts: Sequence[SonarContact]) -> tuple[Echo, ...]:
    """Return the plausible ones of contacts, turned from the own body frame by the own attitude."""
    return tuple(
        [
            Echo(*contact_of(body_to_ned(nav.attitude, relative_of(contact))))
            for contact in contacts
            if is_contact(contact)
        ]
    )
