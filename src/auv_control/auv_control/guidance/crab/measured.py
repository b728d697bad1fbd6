"""The measured crab angle: course over ground minus heading, through a low pass. It needs bottom lock."""

from __future__ import annotations

from dataclasses import dataclass

from auv_control.guidance.crab import CrabLaw, CrabView
from auv_core.compiled import inlined
from auv_core.geometry import smallest_angle
from auv_core.integrate import State
from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """The defaults are for a Doppler log that measures the velocity over ground."""

    lookahead_m: float = param("lookahead distance Delta (m)", default=10.0, above=0.0, maximum=1e4)
    time_constant_s: float = param("time constant of the low pass (s)", default=1.0, above=0.0, maximum=1e4)

    def share(self, period_s: float) -> float:
        """Return the share of a new angle in the low pass, for a control period (s)."""
        return min(period_s / self.time_constant_s, 1.0)


@inlined
def low_passed(beta: float, drift_rad: float, share: float) -> float:
    """Return the filtered angle (rad) after a new one of course minus heading, which counts by `share`."""
    return smallest_angle(beta + share * smallest_angle(drift_rad - beta))


class Crab(CrabLaw):
    """The state is the filtered angle (rad)."""

    def __init__(self, params: Params, period_s: float) -> None:
        self.lookahead_m = params.lookahead_m
        self._share = params.share(period_s)

    def initial_state(self, view: CrabView) -> State:
        """Return the measured angle (rad)."""
        return (view.drift_rad,)

    def step(self, state: State, view: CrabView) -> tuple[float, State]:
        """Return the filtered angle (rad)."""
        (beta,) = state
        beta = low_passed(beta, view.drift_rad, self._share)
        return beta, (beta,)
