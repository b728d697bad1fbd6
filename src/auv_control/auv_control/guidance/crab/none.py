"""
No allowance: plain line of sight. In a cross current the cross-track error tends to Delta tan(crab angle).
"""

from __future__ import annotations

from dataclasses import dataclass

from auv_control.guidance.crab import CrabLaw, CrabView
from auv_core.integrate import State
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """The lookahead distance only."""

    lookahead_m: float = param("lookahead distance Delta (m)", default=15.0, above=0.0, maximum=1e4)


class Crab(CrabLaw):
    """The angle is zero."""

    def __init__(self, params: Params, period_s: float) -> None:
        self.lookahead_m = params.lookahead_m

    def initial_state(self, view: CrabView) -> State:
        """Return nothing: this law has no state."""
        return ()

    def step(self, state: State, view: CrabView) -> tuple[float, State]:
        """Return zero."""
        return 0.0, ()
