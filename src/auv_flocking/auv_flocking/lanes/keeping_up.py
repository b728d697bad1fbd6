"""
Whether a vehicle keeps up with the speed that coordination asks for.

Deviation: the study has 20 s for both low passes. A vehicle that comes into its lane astern of the others is
asked for 0.4 m/s more at once, and what the hull has not yet gained then counts as missing. The vehicle says
that it cannot keep up, and the reference of the whole fleet falls to it and stays there. In a current of
0.3 m/s two of four fleets had not formed after 660 s; with 60 s for the missing speed they form after 444 s
and 464 s. A vehicle that lacks 0.15 m/s says so 31 s later.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from auv_core.params import param


@dataclass(frozen=True)
class Params:
    """Two low passes, and two thresholds on that of the missing speed."""

    memory_s: float = param("time constant of the low pass of the rate (s)", default=20.0, above=0.0)
    missing_memory_s: float = param(
        "time constant of the low pass of the missing speed (s)", default=60.0, above=0.0
    )
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
    missing_share = min(period_s / params.missing_memory_s, 1.0)
    missing_mps = state.missing_mps + missing_share * (missing_mps - state.missing_mps)
    threshold_mps = params.restored_mps if state.is_limited else params.limited_mps
    return KeepingUp(
        missing_mps, state.rate_mps + share * (rate_mps - state.rate_mps), missing_mps > threshold_mps
    )
