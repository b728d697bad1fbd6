"""Claims about the check of lanes against turning circle, speeds and current."""

import pytest
from torpedo_flights import remus

from auv_control.guidance.feasibility import allowed_speeds, check_lane, least_radius_m
from auv_control.guidance.paths import circle, racetrack, waypoints
from auv_core.models import Handling

STRAIGHT_ON = racetrack.Path(racetrack.Params()).track


class Remus:
    """The turning circles of `remus100` as measured, without flying them."""

    handling = Handling(False, 0.8, 1.6, 0.19)
    top_speed_mps = 2.5536

    def turn_radius_m(self, speed_mps):
        """Return the radius between two measured turns (m)."""
        return 17.6 + 5.9 / speed_mps


def test_the_least_radius_grows_with_the_current():
    assert least_radius_m(Remus(), 1.5, 0.0) == pytest.approx(26.0, abs=1.0)
    assert least_radius_m(Remus(), 1.5, 0.25) == pytest.approx(33.0, abs=1.0)
    assert least_radius_m(Remus(), 1.5, 0.5) == pytest.approx(45.0, abs=1.5)


@pytest.mark.parametrize("lane_m", [-30.0, 0.0, 30.0])
def test_the_lanes_of_the_studies_are_feasible(lane_m):
    check_lane(Remus(), STRAIGHT_ON, lane_m, 1.5, 0.3)


def test_a_path_shorter_than_the_hull_is_refused():
    track = waypoints.Path(waypoints.Params((0.0, 0.0, 0.5, 0.0), acceptance_m=0.1)).track
    with pytest.raises(ValueError, match=r"^path: a length of 0.5 m is not allowed; allowed: at least 1.6 m"):
        check_lane(Remus(), track, 0.0, 1.5, 0.0)


def test_speeds_that_do_not_exist_are_said_in_words():
    assert allowed_speeds(Remus(), 0.3) == "1.1 to 2.25 m/s over ground in a current of 0.3 m/s"
    assert allowed_speeds(Remus(), 0.9).startswith(
        "none in a current of 0.9 m/s, since a current must be below"
    )
    weak = Remus()
    weak.top_speed_mps = 0.5
    words = "none, since the least speed 0.8 m/s is above the top speed 0.5 m/s"
    assert allowed_speeds(weak, 0.0) == words


@pytest.mark.parametrize(
    ("track", "lane_m", "current_mps", "words"),
    [
        (
            circle.Path(circle.Params(radius_m=30.0)).track,
            0.0,
            0.5,
            r"lane: a curve of 30 m in the lane at 0 m",
        ),
        (
            STRAIGHT_ON,
            60.0,
            0.3,
            r"lane: 0.9 m/s in the lane at 60 m is not allowed; allowed: 1.1 to 2.25 m/s",
        ),
        (STRAIGHT_ON, -120.0, 0.3, r"lane: 2.7 m/s in the lane at -120 m is not allowed"),
        (STRAIGHT_ON, 160.0, 0.0, r"lane: 160 m inside a curve of 150 m is not allowed; allowed: less than"),
    ],
)
def test_what_cannot_be_flown_is_refused(track, lane_m, current_mps, words):
    with pytest.raises(ValueError, match=words):
        check_lane(Remus(), track, lane_m, 1.5, current_mps)


@pytest.mark.slow
def test_the_model_refuses_the_same():
    with pytest.raises(ValueError, match=r"lane: a curve of 30 m"):
        check_lane(remus(), circle.Path(circle.Params(radius_m=30.0)).track, 0.0, 1.5, 0.5)
    check_lane(remus(), STRAIGHT_ON, 30.0, 1.5, 0.3)
