"""
Depth autopilot: stern plane from the depth error, by way of a pitch command.

    z_d     slews to z_ref at min(v_max, c U sin th_lim)
    th_lim  = min(th_max, b k_s U^2)
    th_d    = K_z (z - z_d) + K_zi int (z - z_d) - asin(z_d' / U),  clipped at th_lim
    delta_s = -sat( (K_p (th_d - th) - K_d q + K_i int (th_d - th)) s(U) + delta_max sin th_d / (k_s U^2) )

Successive loops (Fossen 2021, Handbook of Marine Craft Hydrodynamics and Motion Control, ch. 15): the pitch
loop is ten times faster than the depth loop. The planes' moment grows with U^2 and the righting moment does
not, so planes at their limit delta_max hold a pitch of sin th = k_s U^2 and no more. The last term is the
plane angle that holds th_d. A positive plane angle puts the nose down.
"""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass
from typing import NamedTuple

from auv_core.compiled import inlined
from auv_core.geometry import clipped
from auv_core.params import param


class DepthGains(NamedTuple):
    """`Params` as compiled functions take them."""

    depth_radpm: float
    depth_integral_radpms: float
    integrate_within_m: float
    pitch: float
    pitch_rate_s: float
    pitch_integral_ps: float
    pitch_max_rad: float
    pitch_share: float
    slew_max_mps: float
    slew_share: float
    static_pitch_s2pm2: float
    plane_max_rad: float
    design_speed_mps: float
    speed_floor_mps: float
    least_scale: float
    largest_scale: float


@dataclass(frozen=True)
class Params:
    """The defaults are for `remus100`."""

    depth_radpm: float = param("pitch per depth error K_z (rad/m)", default=0.1, above=0.0)
    depth_integral_radpms: float = param(
        "pitch per integrated depth error K_zi (rad/(m s))", default=0.002, minimum=0.0
    )
    integrate_within_m: float = param("largest depth error that is integrated (m)", default=3.0, minimum=0.0)
    pitch: float = param("plane angle per pitch error K_p (rad/rad)", default=3.0, above=0.0)
    pitch_rate_s: float = param("plane angle per pitch rate K_d (s)", default=3.0, minimum=0.0)
    pitch_integral_ps: float = param(
        "plane angle per integrated pitch error K_i (1/s)", default=0.3, minimum=0.0
    )
    pitch_max_rad: float = param(
        "largest pitch command th_max (rad)", default=math.radians(20.0), above=0.0, maximum=1.5
    )
    pitch_share: float = param("share b of the static pitch limit", default=0.85, above=0.0, maximum=1.0)
    slew_max_mps: float = param("largest rate v_max of the depth command (m/s)", default=0.4, above=0.0)
    slew_share: float = param(
        "share c of the vertical speed at the pitch limit that the depth command uses",
        default=0.7,
        above=0.0,
        maximum=1.0,
    )
    static_pitch_s2pm2: float = param(
        "largest sine of the pitch that the planes hold, per squared speed k_s (s^2/m^2)",
        default=0.164,
        above=0.0,
    )
    plane_max_rad: float = param(
        "largest plane angle (rad)", default=math.radians(15.0), above=0.0, maximum=1.5
    )
    design_speed_mps: float = param("speed of the pitch gains (m/s)", default=1.5, above=0.0)
    speed_floor_mps: float = param("least speed that scales the gains (m/s)", default=0.5, above=0.0)
    least_scale: float = param("least factor on the pitch gains", default=0.4, above=0.0)
    largest_scale: float = param("largest factor on the pitch gains", default=3.0, above=0.0)

    @property
    def gains(self) -> DepthGains:
        """All of these parameters."""
        return DepthGains(*map(float, astuple(self)))


class DepthState(NamedTuple):
    """Depth command z_d (m) and the integrals of the errors of depth (m s) and pitch (rad s)."""

    depth_command_m: float
    depth_integral_ms: float
    pitch_integral_rads: float


class DepthOutput(NamedTuple):
    """Stern plane angle and pitch command (rad), and the state after the control period."""

    stern_plane_rad: float
    pitch_command_rad: float
    state: DepthState


@inlined
def pitch_limit(speed_mps: float, gains: DepthGains) -> float:
    """Return th_lim, the largest pitch command at a speed (rad)."""
    return min(gains.pitch_max_rad, gains.pitch_share * gains.static_pitch_s2pm2 * speed_mps * speed_mps)


@inlined
def dived(
    depth_m: float, depth_ref_m: float, pitch_rad: float, pitch_rate_radps: float, speed_mps: float,
    state: DepthState, period_s: float, gains: DepthGains,
) -> DepthOutput:  # fmt: skip
    """
    Return the stern plane angle of a control period.

    Parameters
    ----------
    depth_m, depth_ref_m : float
        Actual and commanded depth (m; NED z).
    pitch_rad, pitch_rate_radps : float
        Pitch (rad, nose up) and its rate q (rad/s).
    speed_mps : float
        Speed U (m/s).
    state : DepthState
        After the last control period; at the start `(depth, 0, 0)`.
    period_s : float
        Control period (s).
    gains : DepthGains
        From `Params.gains`.

    """
    speed = max(speed_mps, gains.speed_floor_mps)
    limit = pitch_limit(speed, gains)
    slew_mps = min(gains.slew_max_mps, gains.slew_share * speed * math.sin(limit))
    change_m = clipped(depth_ref_m - state.depth_command_m, slew_mps * period_s)
    command_m = state.depth_command_m + change_m
    error_m = depth_m - command_m
    asked = (
        gains.depth_radpm * error_m
        + gains.depth_integral_radpms * state.depth_integral_ms
        - math.asin(clipped(change_m / (period_s * speed), 1.0))
    )
    pitch_command = clipped(asked, limit)
    depth_integral = state.depth_integral_ms
    if pitch_command == asked and abs(error_m) <= gains.integrate_within_m:
        depth_integral += period_s * error_m
    pitch_error = pitch_command - pitch_rad
    scale = gains.design_speed_mps / speed
    scale = min(max(scale * scale, gains.least_scale), gains.largest_scale)
    wanted = scale * (
        gains.pitch * pitch_error
        - gains.pitch_rate_s * pitch_rate_radps
        + gains.pitch_integral_ps * state.pitch_integral_rads
    ) + gains.plane_max_rad * math.sin(pitch_command) / (gains.static_pitch_s2pm2 * speed * speed)
    plane = clipped(wanted, gains.plane_max_rad)
    pitch_integral = state.pitch_integral_rads
    if plane == wanted:
        pitch_integral += period_s * pitch_error
    return DepthOutput(-plane, pitch_command, DepthState(command_m, depth_integral, pitch_integral))
