"""Whether a vehicle keeps up with the speed that coordination asks for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """A low pass, and two thresholds on it."""

    memory_s: float = param("time constant of the low passes (s)", default=20.0, above=0.0)
    limited_mps: float = param(
        "missing speed from which a vehicle cannot keep up (m/s)", default=0.06, above=0.0
    )
    restored_mps: float = param("missing speed below which it can again (m/s)", default=0.02)


class KeepingUp(NamedTuple):
    """Missing speed and rate of gamma - v_L t, low-passed (m/s), and whether the vehicle cannot keep up."""

    missing_mps: float = 0.0
    rate_mps: float = 0.0
    is_limited: bool = False


def kept_up(
    state: KeepingUp, missing_mps: float, rate_mps: float, period_s: float, params: Params
) -> KeepingUp:
    """
    Return the state after a control period in the lane.

    Parameters
    ----------
    state : KeepingUp
        After the last control period; `KeepingUp()` when the vehicle comes into its lane.
    missing_mps : float
        Commanded minus actual speed along the lane (m/s).
    rate_mps : float
        Rate of the path parameter minus v_L (m/s).
    period_s : float
        Control period (s).
    params : Params
        Thresholds.

    """
    share = min(period_s / params.memory_s, 1.0)
    missing_mps = state.missing_mps + share * (missing_mps - state.missing_mps)
    threshold_mps = params.restored_mps if state.is_limited else params.limited_mps
    return KeepingUp(
        missing_mps, state.rate_mps + share * (rate_mps - state.rate_mps), missing_mps > threshold_mps
    )
