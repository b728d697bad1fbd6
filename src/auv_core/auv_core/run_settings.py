"""Settings that all components of a run share; a scenario and the components' configurations use them."""

from __future__ import annotations

from dataclasses import dataclass

from auv_core.params import param


@dataclass(frozen=True, kw_only=True)
class RunSettings:
    """Seed and periods of a run, and when the computer of a vehicle fails."""

    seed: int = param("seed of every random number", default=1, minimum=0, maximum=2**31 - 1)
    dt_s: float = param("physics step (s)", default=0.02, minimum=1e-5, maximum=10.0)
    period_s: float = param(
        "control period (s), a whole number of physics steps", default=0.1, minimum=1e-5, maximum=10.0
    )
    fails_at_s: float | None = param(
        "scenario time from which the vehicle's computer does nothing (s); null: never",
        default=None,
        minimum=0.0,
    )
