"""
Heading autopilot: rudder from the heading error.

    delta_r = sat( (K_p clip(e) + K_d (r_ref - r) + K_i int e + r_ref / K) s(U) ),    e = ssa(psi_ref - psi)

PID with feed-forward on Nomoto's first-order model r = K delta_r / (T s + 1) (Fossen 2021, Handbook of Marine
Craft Hydrodynamics and Motion Control, ch. 15). K grows with the speed U, so s(U) = U_0 / U, clipped, keeps
the loop gain. The error of the proportional term is clipped, so a long turn saturates the rudder but not the
damping. The integral is held while the rudder saturates or the error is large.
"""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass
from typing import NamedTuple

from auv_core.compiled import inlined
from auv_core.geometry import clipped, smallest_angle
from auv_core.params import param


class HeadingGains(NamedTuple):
    """`Params` as compiled functions take them."""

    proportional: float
    rate_s: float
    integral_ps: float
    nomoto_gain_ps: float
    error_clip_rad: float
    integrate_within_rad: float
    design_speed_mps: float
    speed_floor_mps: float
    least_scale: float
    largest_scale: float
    rudder_max_rad: float


@dataclass(frozen=True)
class Params:
    """The defaults are for `remus100`: natural frequency 0.7 rad/s and damping ratio 1 at 1.5 m/s."""

    proportional: float = param("rudder per heading error K_p (rad/rad)", default=1.5, above=0.0)
    rate_s: float = param("rudder per error of the turn rate K_d (s)", default=1.5, minimum=0.0)
    integral_ps: float = param("rudder per integrated heading error K_i (1/s)", default=0.05, minimum=0.0)
    nomoto_gain_ps: float = param("steady turn rate per rudder angle K (1/s)", default=0.3, above=0.0)
    error_clip_rad: float = param("limit of the heading error in K_p e (rad)", default=0.5, above=0.0)
    integrate_within_rad: float = param(
        "largest heading error that is integrated (rad)", default=0.3, minimum=0.0
    )
    design_speed_mps: float = param("speed U_0 of the gains (m/s)", default=1.5, above=0.0)
    speed_floor_mps: float = param("least speed that scales the gains (m/s)", default=0.5, above=0.0)
    least_scale: float = param("least factor on the rudder", default=0.5, above=0.0)
    largest_scale: float = param("largest factor on the rudder", default=1.7, above=0.0)
    rudder_max_rad: float = param(
        "largest rudder angle (rad)", default=math.radians(15.0), above=0.0, maximum=1.5
    )

    @property
    def gains(self) -> HeadingGains:
        """All of these parameters."""
        return HeadingGains(*map(float, astuple(self)))


@inlined
def steered(
    error_rad: float, rate_error_radps: float, rate_ref_radps: float, speed_mps: float, integral_rads: float,
    period_s: float, gains: HeadingGains,
) -> tuple[float, float]:  # fmt: skip
    """
    Return the rudder angle (rad) of a control period, and the integral of the heading error after it (rad s).

    Parameters
    ----------
    error_rad : float
        Commanded minus actual heading (rad; any number of turns).
    rate_error_radps, rate_ref_radps : float
        Commanded minus actual turn rate, and commanded turn rate (rad/s).
    speed_mps : float
        Speed U (m/s).
    integral_rads : float
        Integral of the heading error (rad s).
    period_s : float
        Control period (s).
    gains : HeadingGains
        From `Params.gains`.

    """
    error = smallest_angle(error_rad)
    scale = gains.design_speed_mps / max(speed_mps, gains.speed_floor_mps)
    scale = min(max(scale, gains.least_scale), gains.largest_scale)
    asked = scale * (
        gains.proportional * clipped(error, gains.error_clip_rad)
        + gains.rate_s * rate_error_radps
        + gains.integral_ps * integral_rads
        + rate_ref_radps / gains.nomoto_gain_ps
    )
    rudder = clipped(asked, gains.rudder_max_rad)
    if rudder == asked and abs(error) < gains.integrate_within_rad:
        integral_rads += period_s * error
    return rudder, integral_rads
