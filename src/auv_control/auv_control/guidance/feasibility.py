"""
Whether a vehicle can fly a lane in a current: checked before a run.

A current from ahead slows the vehicle through the water at a given speed over ground, a current from astern
would need less than its least speed. Curves must be wider than the turning circle, with a reserve of 1 / 0.8:

    R_lane >= v_g R_turn(v_w) / (0.8 v_w),     v_w = v_g - V_c,     u_min + V_c <= v_g <= u_max - V_c
"""

from __future__ import annotations

from typing import Protocol

from auv_control.guidance.track import Track
from auv_core.models import Handling

TURN_RESERVE = 0.8
"""Share of the largest turn rate that a curve may need."""


class Turning(Protocol):
    """What the check asks of a vehicle model."""

    @property
    def handling(self) -> Handling:
        """How the vehicle handles."""

    @property
    def top_speed_mps(self) -> float:
        """Highest speed through the water (m/s)."""

    def turn_radius_m(self, speed_mps: float) -> float:
        """Return the radius of the tightest turn at a speed through the water (m)."""


def least_radius_m(vehicle: Turning, speed_mps: float, current_mps: float) -> float:
    """Return the least radius of a curve (m) at a speed over ground in any current of a speed (m/s)."""
    water_mps = max(speed_mps - current_mps, vehicle.handling.least_speed_mps)
    return speed_mps * vehicle.turn_radius_m(water_mps) / (TURN_RESERVE * water_mps)


def allowed_speeds(vehicle: Turning, current_mps: float) -> str:
    """Return in words at which speeds over ground a vehicle can run against and with a current (m/s)."""
    least_mps, top_mps = vehicle.handling.least_speed_mps, vehicle.top_speed_mps
    low_mps, high_mps = least_mps + current_mps, top_mps - current_mps
    if least_mps > top_mps:
        return f"none, since the least speed {least_mps:.3g} m/s is above the top speed {top_mps:.3g} m/s"
    if low_mps > high_mps:
        most_mps = 0.5 * (top_mps - least_mps)
        return f"none in a current of {current_mps:g} m/s, since a current must be below {most_mps:.3g} m/s"
    return f"{low_mps:.3g} to {high_mps:.3g} m/s over ground in a current of {current_mps:g} m/s"


def check_through_water(vehicle: Turning, field: str, speed_mps: float) -> None:
    """Raise ValueError, for a field, unless a vehicle can run at a speed through the water (m/s)."""
    least_mps, largest_mps = vehicle.handling.least_speed_mps, vehicle.top_speed_mps
    if not least_mps <= speed_mps <= largest_mps:
        raise ValueError(
            f"{field}: {speed_mps!r} is not allowed; allowed: {least_mps:.3g} to {largest_mps:.3g} m/s "
            "through the water"
        )


def check_lane(vehicle: Turning, track: Track, lane_m: float, speed_mps: float, current_mps: float) -> None:
    """
    Check that a vehicle can fly a lane.

    Parameters
    ----------
    vehicle : Turning
        Model of the vehicle.
    track : Track
        The track.
    lane_m : float
        Offset of the lane to starboard (m).
    speed_mps : float
        Speed along the track (m/s); in a curve the lane's speed is (1 - kappa o_y) times this.
    current_mps : float
        Largest speed of the current (m/s).

    Raises
    ------
    ValueError
        With the value and what is allowed.

    """
    least_mps = vehicle.handling.least_speed_mps + current_mps
    largest_mps = vehicle.top_speed_mps - current_mps
    hull_m = vehicle.handling.hull_length_m
    if track.length_m < hull_m:
        raise ValueError(
            f"path: a length of {track.length_m:.3g} m is not allowed; allowed: at least {hull_m:g} m, "
            "the length of a hull"
        )
    for curvature_pm in sorted(track.curvatures()):
        ratio = 1.0 - curvature_pm * lane_m
        lane_mps = ratio * speed_mps
        if ratio <= 0.0:
            raise ValueError(
                f"lane: {lane_m:g} m inside a curve of {1.0 / abs(curvature_pm):g} m is not allowed; "
                "allowed: less than the radius"
            )
        where = f"in the lane at {lane_m + 0.0:g} m"  # without a sign for minus zero
        if not least_mps <= lane_mps <= largest_mps:
            raise ValueError(
                f"lane: {lane_mps:.3g} m/s {where} is not allowed; "
                f"allowed: {allowed_speeds(vehicle, current_mps)}"
            )
        needed_m = least_radius_m(vehicle, lane_mps, current_mps)
        if abs(curvature_pm) * needed_m > ratio:
            raise ValueError(
                f"lane: a curve of {ratio / abs(curvature_pm):.3g} m {where} is not allowed; allowed: at "
                f"least {needed_m:.3g} m at {lane_mps:.3g} m/s in a current of {current_mps:g} m/s"
            )
