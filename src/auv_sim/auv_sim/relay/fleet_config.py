"""The fleet of a relay."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.params import param


@dataclass(frozen=True, kw_only=True)
class FleetConfig:
    """Names of the vehicles, and how old their states may be."""

    vehicle_ids: tuple[str, ...] = param("names of the vehicles in the order of their acoustic addresses")
    state_max_age_s: float = param(
        "age of a vehicle's state above which its modem is silent (s); at least two control periods",
        default=0.5,
        above=0.0,
    )

    obstacle_count: int = param(
        "number of obstacles; obstacles.o<number> has each, from 0", default=0, minimum=0, maximum=10_000
    )

    def __post_init__(self) -> None:
        """Refuse an empty fleet."""
        if not self.vehicle_ids:
            raise ValueError("vehicle_ids: an empty list is not allowed; allowed: one name per modem")
