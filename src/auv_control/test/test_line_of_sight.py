"""Claims about guidance by line of sight, with a point whose heading follows at a limited turn rate."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.guidance.crab import alos, ilos, measured, none
from auv_control.guidance.line_of_sight import TURN_RATE_MAX_RADPS, OverGround, aimed, over_ground, sight
from auv_control.guidance.paths import circle, waypoints
from auv_control.guidance.track import TrackPoint
from auv_core.geometry import clipped, quaternion_from_heading, smallest_angle
from auv_core.messages import VehicleState

PERIOD_S, SPEED_MPS = 0.1, 1.5
LINE = waypoints.Path(waypoints.Params(waypoints_ned_m=(0.0, 0.0, 5000.0, 0.0)))
LAWS = {
    "measured": measured.Crab(measured.Params(), PERIOD_S),
    "alos": alos.Crab(alos.Params(), PERIOD_S),
    "ilos": ilos.Crab(ilos.Params(), PERIOD_S),
    "none": none.Crab(none.Params(), PERIOD_S),
}


def cross_track_m(path, law, current, *, aside_m=10.0, lane_m=0.0, duration_s=300.0):
    """Return the cross-track errors (m) of a point that holds its speed over ground along the path."""
    start = path.track.at(0.0)
    north_m = start.north_m - aside_m * math.sin(start.course_rad)
    east_m = start.east_m + aside_m * math.cos(start.course_rad)
    heading_rad, water_mps, crab, errors_m = start.course_rad, SPEED_MPS, None, []
    place = path.engage(north_m, east_m)
    for _ in range(round(duration_s / PERIOD_S)):
        over = (
            water_mps * math.cos(heading_rad) + current[0],
            water_mps * math.sin(heading_rad) + current[1],
        )
        own = OverGround(north_m, east_m, math.atan2(over[1], over[0]), math.hypot(*over), heading_rad)
        place = path.follow(place, north_m, east_m)
        found = sight(aimed(own, path.track.point(*place), lane_m, law.lookahead_m), law, crab)
        crab = found.crab
        errors_m.append(found.cross_track_m)
        rate = found.turn_rate_radps + 0.7 * smallest_angle(found.heading_rad - heading_rad)
        heading_rad += PERIOD_S * clipped(rate, math.radians(3.8))
        water_mps += PERIOD_S * clipped(SPEED_MPS - found.along_mps, 0.3)
        north_m, east_m = north_m + PERIOD_S * over[0], east_m + PERIOD_S * over[1]
    return np.array(errors_m)


@pytest.mark.parametrize("kind", ["measured", "alos", "ilos"])
@pytest.mark.parametrize("current", [(0.0, 0.0), (0.0, 0.5), (0.0, -0.5), (-0.5, 0.0)])
def test_a_law_with_a_crab_angle_ends_on_a_line_in_a_current(kind, current):
    assert abs(cross_track_m(LINE, LAWS[kind], current)[-1]) < 0.03


@pytest.mark.parametrize(("current_mps", "aside_m"), [(0.25, 2.468), (0.5, 4.766)])
def test_plain_line_of_sight_stays_beside_a_line_in_a_cross_current(current_mps, aside_m):
    """By Delta tan(a), with sin(a) / cos(a)^2 the current per speed along the line of sight."""
    errors_m = cross_track_m(LINE, LAWS["none"], (0.0, current_mps))
    assert errors_m[-1] == pytest.approx(aside_m, abs=0.01)


def test_on_a_circle_the_measured_angle_follows_the_current_and_a_learnt_one_lags():
    ring = circle.Path(circle.Params(radius_m=50.0))
    worst = {
        kind: abs(cross_track_m(ring, LAWS[kind], (0.0, 0.3))[1500:]).max() for kind in ("measured", "alos")
    }
    assert worst["measured"] < 0.6
    assert 1.0 < worst["alos"] < 4.0


@pytest.mark.parametrize("lane_m", [-30.0, 30.0])
def test_a_lane_is_the_parallel_curve(lane_m):
    ring = circle.Path(circle.Params(radius_m=150.0))
    errors_m = cross_track_m(ring, LAWS["measured"], (0.0, 0.0), aside_m=lane_m, lane_m=lane_m)
    assert abs(errors_m).max() < 0.3
    assert abs(errors_m[-1]) < 0.01


@settings(max_examples=100, deadline=None)
@given(
    st.tuples(*[st.floats(-300.0, 300.0)] * 3),
    st.floats(-7.0, 7.0),
    st.floats(0.0, 3.0),
    st.floats(-0.04, 0.04),
)
def test_commands_are_bounded_and_lead_towards_the_lane(places, course_rad, speed_mps, curvature_pm):
    point = TrackPoint(0.0, 0.0, 0.3, curvature_pm)
    own = OverGround(places[0], places[1], course_rad, speed_mps, course_rad)
    law = LAWS["none"]
    found = sight(aimed(own, point, 0.1 * places[2], law.lookahead_m), law, None)
    assert abs(found.turn_rate_radps) <= TURN_RATE_MAX_RADPS
    assert abs(found.along_mps) <= speed_mps
    assert (found.heading_rad - 0.3) * found.cross_track_m <= 0.0
    assert abs(found.heading_rad - 0.3) < 0.5 * math.pi


def test_motion_over_ground_comes_from_the_navigation():
    nav = VehicleState(0, (1.0, 2.0, 30.0), quaternion_from_heading(0.5), (1.2, 0.3, 0.0, 0.0, 0.0, 0.0))
    own = over_ground(nav)
    assert own == pytest.approx((1.0, 2.0, 0.5 + math.atan2(0.3, 1.2), math.hypot(1.2, 0.3), 0.5))
    assert over_ground(nav._replace(nu=(0.0,) * 6)).course_rad == pytest.approx(0.5)
