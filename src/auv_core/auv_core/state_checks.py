"""Checks of states (valid, finite, within the limits of a hull, with an attitude) and commands."""

from __future__ import annotations

import math
from collections.abc import Sequence

from auv_core.geometry import Quat
from auv_core.messages import VehicleState

LARGEST = 1e9
"""Largest number in a state or command, in any unit."""

_EXACT_NORM = 1e-6
_ALMOST_NORM = 0.02


def is_command(numbers: Sequence[float]) -> bool:
    """Return whether these numbers can be a command: finite and of plausible size."""
    return math.isfinite(sum(numbers)) and min(numbers) >= -LARGEST and max(numbers) <= LARGEST


def checked_state(
    state: VehicleState, *, position_max_m: float = LARGEST, speed_max_mps: float = LARGEST
) -> tuple[VehicleState | None, str]:
    """
    Return a state with a normalised attitude and an empty text, or None and the reason why it is not a state.

    Parameters
    ----------
    state : VehicleState
        State from a navigation or a vehicle.
    position_max_m : float
        Largest coordinate of a position (m; NED).
    speed_max_mps : float
        Largest speed (m/s).

    """
    w, x, y, z = q = state.attitude
    u, v, heave, roll_radps, pitch_radps, yaw_radps = state.nu
    north, east, down = state.position
    square = w * w + x * x + y * y + z * z
    if (  # almost every state, in a fraction of the time that the reasons take
        state.is_valid
        and -_EXACT_NORM <= square - 1.0 <= _EXACT_NORM
        and -position_max_m <= north <= position_max_m
        and -position_max_m <= east <= position_max_m
        and -position_max_m <= down <= position_max_m
        and u * u + v * v + heave * heave <= speed_max_mps * speed_max_mps
        and abs(roll_radps) + abs(pitch_radps) + abs(yaw_radps) <= LARGEST
        and 0.0 <= state.position_sd_m <= LARGEST
        and 0.0 <= state.heading_sd_rad <= LARGEST
    ):
        return state, ""
    words = _why_none(state, position_max_m, speed_max_mps)
    if words:
        return None, words
    if abs(square - 1.0) > _ALMOST_NORM:
        return None, f"attitude of length {math.sqrt(square):.3g}, allowed: 1"
    return state._replace(attitude=_unit(q, math.sqrt(square))), ""


def _why_none(state: VehicleState, position_max_m: float, speed_max_mps: float) -> str:
    if not state.is_valid:
        return "marked as not valid"
    for number in (*state.position, *state.attitude, *state.nu, state.position_sd_m, state.heading_sd_rad):
        if not -LARGEST <= number <= LARGEST:
            return f"a number that is none: {number}"
    if state.position_sd_m < 0.0 or state.heading_sd_rad < 0.0:
        return f"negative deviation: {state.position_sd_m:g} m, {state.heading_sd_rad:g} rad"
    farthest_m = max(map(abs, state.position))
    if farthest_m > position_max_m:
        return f"position {farthest_m:.3g} m from the origin, allowed: {position_max_m:g} m"
    speed_mps = math.hypot(state.nu[0], state.nu[1], state.nu[2])
    if speed_mps > speed_max_mps:
        return f"speed {speed_mps:.3g} m/s, allowed: {speed_max_mps:.3g} m/s"
    return ""


def _unit(q: Quat, length: float) -> Quat:
    return (q[0] / length, q[1] / length, q[2] / length, q[3] / length)
