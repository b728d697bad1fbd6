"""
Controllers: from a reference to what the actuators shall do.

To add one, write one file with ``Params`` and ``Controller(params, period_s)`` with ``command``
(``'wrench'`` or ``'velocity'``: what it gives, which must be what the vehicle's model takes) and ``step(nav,
reference) -> Wrench | VelocityCommand``, called once per control period with the vehicle's own navigation
(`auv_core.messages.VehicleState`) and a `VelocityReference`.  The file's name is its ``kind``.
"""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.geometry import Vec3


@dataclass(frozen=True, slots=True)
class VelocityReference:
    """What a flocking law asks of its vehicle: velocity over ground (m/s; NED) and heading (rad)."""

    velocity: Vec3
    heading_rad: float
