"""Whether a vehicle can be a member of a fleet of lanes, its lane apart: room, transit and loitering."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from auv_control.guidance.feasibility import TURN_RESERVE, Turning, check_through_water
from auv_control.guidance.track import Track
from auv_core.geometry import Box, distance
from auv_flocking.fleets._lane_settings import Params


def check_member(vehicle: Turning, params: Params, fleet_size: int, current_mps: float) -> None:
    """
    Check that a vehicle has room in its slot, holds the speed of transit, and can loiter.

    Parameters
    ----------
    vehicle : Turning
        Model of the vehicle.
    params : Params
        Of the fleet.
    fleet_size : int
        Number of vehicles.
    current_mps : float
        Largest speed of the current (m/s).

    Raises
    ------
    ValueError
        With the field, the value and what is allowed.

    """
    _check_room(vehicle, params, fleet_size)
    check_through_water(vehicle, "transit_speed_mps", params.transit_speed_mps)
    water_mps = params.transit_speed_mps
    needed_m = (water_mps + current_mps) * vehicle.turn_radius_m(water_mps) / (TURN_RESERVE * water_mps)
    if params.loiter_radius_m < needed_m:
        raise ValueError(
            f"loiter_radius_m: {params.loiter_radius_m!r} is not allowed; allowed: at least {needed_m:.3g} m "
            f"at {water_mps:g} m/s through the water with a current of {current_mps:g} m/s astern"
        )


def lane_reach(track: Track, lane_m: float, loiter: Track, depths_m: Sequence[float]) -> Box:
    """Return a box around a lane of a track and a circle to loiter on, between the depths (m; NED)."""
    shallow_m, deep_m = min(depths_m), max(depths_m)
    lane = track.box(0.0, track.length_m, shallow_m).grown(abs(lane_m), 0.0)
    circle = loiter.box(0.0, loiter.length_m, deep_m)
    north_m, east_m, _ = map(min, lane.lowest, circle.lowest)
    far_north_m, far_east_m, _ = map(max, lane.highest, circle.highest)
    return Box((north_m, east_m, shallow_m), (far_north_m, far_east_m, deep_m))


def _check_room(vehicle: Turning, params: Params, fleet_size: int) -> None:
    handling = vehicle.handling
    least_m = max(handling.near_m, handling.hull_length_m)
    slots = params.slots(fleet_size)
    apart_m = min((distance(a, b) for a, b in combinations(slots, 2)), default=least_m)
    if apart_m < least_m:
        raise ValueError(
            f"spacing_m: slots {apart_m:.3g} m apart are not allowed; allowed: at least {least_m:g} m, "
            "below which the vehicles are too near to each other"
        )
