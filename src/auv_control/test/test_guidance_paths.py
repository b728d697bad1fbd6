"""Claims about paths of lines and arcs, and about the point of them that is closest to a vehicle."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.guidance.paths import circle, lawnmower, racetrack, waypoints
from auv_control.guidance.track import TrackPoint, joined, point_on, seen_from
from auv_control.references import along_path
from auv_core.params import ConfigError, Section, load

MODERATE = settings(max_examples=60, deadline=None)
SIDES = st.sampled_from(("starboard", "port"))
RADII_M = st.floats(20.0, 200.0)
COURSES = st.floats(-3.0, 3.0)
PLACES_M = st.floats(-500.0, 500.0)
TRACKS = st.one_of(
    st.builds(circle.Params, PLACES_M, PLACES_M, RADII_M, SIDES).map(circle.Path),
    st.builds(racetrack.Params, PLACES_M, PLACES_M, COURSES, RADII_M, RADII_M, SIDES).map(racetrack.Path),
    st.builds(lawnmower.Params, PLACES_M, PLACES_M, COURSES, st.integers(1, 6), RADII_M, RADII_M, SIDES).map(
        lawnmower.Path
    ),
    st.just(waypoints.Path(waypoints.Params())),
).map(lambda path: path.track)


@MODERATE
@given(TRACKS, st.floats(0.0, 3.0))
def test_pieces_are_joined_with_equal_tangents(track, share):
    s_m, step_m = share * track.length_m, 1e-3
    ends = [point_on(piece, piece.length_m) for piece in track.pieces]
    starts = [*track.pieces[1:], track.pieces[0]] if track.is_closed else track.pieces[1:]
    for end, start in zip(ends, starts, strict=False):
        assert math.hypot(end.north_m - start.north_m, end.east_m - start.east_m) < 1e-6
        assert math.cos(end.course_rad - start.course_rad) == pytest.approx(1.0, abs=1e-12)
    here, ahead = track.at(s_m), track.at(s_m + step_m)
    moved = seen_from(here, ahead.north_m, ahead.east_m)
    assert moved.along_m == pytest.approx(step_m, abs=1e-6)
    assert abs(moved.across_m) < 1e-6


@MODERATE
@given(TRACKS, st.floats(0.0, 1.0), st.floats(-15.0, 15.0))
def test_the_closest_point_is_found_from_nearby_and_on_the_whole_track(track, share, across_m):
    s_m = share * track.length_m
    point = track.at(s_m)
    north_m = point.north_m - across_m * math.sin(point.course_rad)
    east_m = point.east_m + across_m * math.cos(point.course_rad)
    found = track.at(track.closest(north_m, east_m))
    assert abs(seen_from(found, north_m, east_m).across_m) <= abs(across_m) + 1e-6
    _, followed_m = track.followed(s_m + 3.0, north_m, east_m)
    assert followed_m == pytest.approx(s_m, abs=1e-5)


@MODERATE
@given(TRACKS, st.floats(0.0, 1.0))
def test_the_box_holds_the_track_and_no_more(track, share):
    last_m = max(share * track.length_m, 1.0)
    box = track.box(0.0, last_m, 5.0)
    points = [track.at(s_m) for s_m in np.linspace(0.0, last_m, 300)]
    norths, easts = [p.north_m for p in points], [p.east_m for p in points]
    assert box.grown(1e-6).holds((min(norths), min(easts), 5.0))
    assert box.grown(1e-6).holds((max(norths), max(easts), 5.0))
    slack_m = last_m / 300
    assert box.highest[0] <= max(norths) + slack_m
    assert box.lowest[1] >= min(easts) - slack_m


def test_the_parameter_of_a_closed_track_grows_from_round_to_round():
    path = circle.Path(circle.Params(radius_m=50.0))
    place = path.engage(0.0, -60.0)
    for tick in range(1, 2001):
        angle = 0.01 * tick
        place = path.follow(place, 55.0 * math.sin(angle), -55.0 * math.cos(angle))
    assert place.s_m == pytest.approx(50.0 * 20.0, abs=1e-6)
    assert path.track.point(*place) == pytest.approx(path.track.at(place.s_m))


def test_an_open_track_extends_beyond_its_ends():
    path = lawnmower.Path(lawnmower.Params(legs=1))
    assert path.follow(path.engage(1.0, 0.0), -4.0, 7.0).s_m == pytest.approx(-4.0)
    assert path.track.at(250.0) == (250.0, 0.0, 0.0, 0.0)


def test_the_racetrack_of_the_studies():
    track = racetrack.Path(racetrack.Params()).track
    assert track.length_m == pytest.approx(1742.5, abs=0.05)
    assert track.at(400.0 + 0.5 * math.pi * 150.0) == pytest.approx(
        (550.0, 150.0, 0.5 * math.pi, 1.0 / 150.0)
    )


def test_a_closed_track_must_end_where_it_begins():
    with pytest.raises(ValueError, match=r"pieces: a gap of 10 m is not allowed; allowed: a closed track"):
        joined(TrackPoint(0.0, 0.0, 0.0, 0.0), ((10.0, 0.0),), is_closed=True)


def test_at_corners_the_vehicle_switches_inside_the_circle_of_acceptance():
    path = waypoints.Path(waypoints.Params(corners="switched", acceptance_m=25.0))
    place = path.engage(170.0, 3.0)
    assert (place.piece, place.s_m) == (0, 170.0)
    assert path.follow(place, 174.0, 0.0).piece == 0
    switched = path.follow(place, 176.0, 0.0)
    assert switched == (1, pytest.approx(200.0))
    assert path.track.point(*switched).course_rad == pytest.approx(0.5 * math.pi)


def test_rounded_corners_keep_inside_the_circle_of_acceptance():
    track = waypoints.Path(waypoints.Params(acceptance_m=25.0)).track
    assert sorted(track.curvatures()) == pytest.approx([0.0, 0.04])
    assert track.at(175.0) == pytest.approx((175.0, 0.0, 0.0, 0.04))
    assert track.at(175.0 + 12.5 * math.pi) == pytest.approx((200.0, 25.0, 0.5 * math.pi, 0.0))


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ({"waypoints_ned_m": [0, 0, 9]}, "waypoints_ned_m: 3 numbers are not allowed; allowed: two for each"),
        ({"acceptance_m": 60.0}, "acceptance_m: 60.0 is not allowed; allowed: less than half of every leg"),
        (
            {"waypoints_ned_m": [0, 0, 99, 0, 1, 1]},
            "waypoints_ned_m: a turn of 179 deg after leg 1 is not allowed; allowed: at most 170 deg",
        ),
    ],
)
def test_waypoints_that_no_path_joins_are_refused(numbers, words):
    with pytest.raises(ConfigError, match=words):
        load(waypoints.Params, numbers, "path")


def test_a_reference_along_an_open_path_stops_at_its_end():
    path = along_path.Reference(along_path.Params(speed_mps=1.0))
    ended = path.at(1000.0)
    assert ended.position == pytest.approx((0.0, 80.0, 10.0))
    assert ended.velocity == (0.0, 0.0, 0.0)
    assert path.period_s is None


def test_a_reference_along_a_closed_path_has_a_period():
    ring = Section("circle", circle.Params(radius_m=50.0))
    path = along_path.Reference(along_path.Params(path=ring, speed_mps=0.5, heading="tangent"))
    assert path.period_s == pytest.approx(200.0 * math.pi)
    assert path.at(50.0 * math.pi).heading_rad == pytest.approx(0.5 * math.pi)
    assert path.at(3.0).turn_rate_radps == pytest.approx(0.01)


def test_a_reference_does_not_take_corners():
    with pytest.raises(ConfigError, match=r"corners: 'switched' is not allowed; allowed: rounded"):
        load(
            along_path.Params, {"path": {"kind": "waypoints", "params": {"corners": "switched"}}}, "reference"
        )
