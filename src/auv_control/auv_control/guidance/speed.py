"""
Speed autopilot: propeller speed from the error of the speed along the path, over ground.

    n = sat( k u_d + K_p e + K_i int e ),     e = u_d - v_along

The floor of n keeps the speed through the water at which fins work, whatever the speed over ground is: with
the current behind, the speed over ground cannot fall below that speed plus the current's. The integral is
held while n saturates and the error would drive it further.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import NamedTuple

from auv_core.compiled import inlined
from auv_core.params import param


class SpeedGains(NamedTuple):
    """`Params` as compiled functions take them."""

    feedforward_rpmpmps: float
    proportional_rpmpmps: float
    integral_rpmpm: float
    least_rpm: float
    largest_rpm: float


@dataclass(frozen=True)
class Params:
    """The defaults are for `remus100`, which runs 1 m/s through the water at 597 rpm."""

    feedforward_rpmpmps: float = param(
        "propeller speed per speed through the water k (rpm/(m/s))", default=597.0, above=0.0
    )
    proportional_rpmpmps: float = param(
        "propeller speed per speed error K_p (rpm/(m/s))", default=200.0, minimum=0.0
    )
    integral_rpmpm: float = param(
        "propeller speed per integrated speed error K_i (rpm/m)", default=40.0, minimum=0.0
    )
    least_rpm: float = param("least propeller speed (rpm)", default=480.0, minimum=0.0)
    largest_rpm: float = param("largest propeller speed (rpm)", default=1525.0, above=0.0)

    def __post_init__(self) -> None:
        if self.least_rpm > self.largest_rpm:
            raise ValueError(
                f"least_rpm: {self.least_rpm!r} is not allowed; "
                f"allowed: at most largest_rpm, {self.largest_rpm!r}"
            )

    @property
    def gains(self) -> SpeedGains:
        """All of these parameters."""
        return SpeedGains(*map(float, astuple(self)))


@inlined
def propelled(
    along_mps: float, speed_ref_mps: float, integral_m: float, period_s: float, gains: SpeedGains
) -> tuple[float, float]:
    """
    Return the propeller speed (rpm) of a control period, and the integrated speed error after it (m).

    Parameters
    ----------
    along_mps, speed_ref_mps : float
        Actual and commanded speed along the path, over ground (m/s).
    integral_m : float
        Integral of the speed error (m).
    period_s : float
        Control period (s).
    gains : SpeedGains
        From `Params.gains`.

    """
    error_mps = speed_ref_mps - along_mps
    asked = (
        gains.feedforward_rpmpmps * speed_ref_mps
        + gains.proportional_rpmpmps * error_mps
        + gains.integral_rpmpm * integral_m
    )
    given = min(max(asked, gains.least_rpm), gains.largest_rpm)
    if given == asked or (given - asked) * error_mps > 0.0:
        integral_m += period_s * error_mps
    return given, integral_m
