"""Claims about turning away from others on the way to the lane."""

import math

import numpy as np
import pytest

from auv_control.guidance.paths import racetrack
from auv_flocking.lanes.status import COURSES, STRAIGHT_ON, LaneNeighbour, LaneStatus, Mode
from auv_flocking.lanes.turn_away import (
    Intent,
    Law,
    Params,
    TurnAway,
    conflict,
    course_offset_rad,
    roll_out,
    uncertainty_m,
)
from auv_flocking.neighbours.estimates import NeighbourEstimate

TRACK = racetrack.Path(racetrack.Params()).track
SLOTS = ((0.0, 0.0, 0.0), (0.0, 15.0, 0.0), (0.0, -15.0, 0.0))
PARAMS = Params(kind="intent_vo")
LAW = Law(10.0, math.radians(3.8), 1.2, 0.35, TRACK.length_m)
OWN = Intent(100.0, 60.0, 30.0, -0.5 * math.pi, 1.5, 100.0, 15.0, 30.0, 0.0, 0.0)


def _others(**changes):
    """Return a neighbour that comes from the other side towards the lanes, at the same depth."""
    status = LaneStatus(100.0, 0.0, 0.0, Mode.TRANSIT, False, STRAIGHT_ON, 30.0)
    other = LaneNeighbour(1, 0.0, status, 0.0, (100.0, 30.0, 30.0), (0.0, 1.5, 0.0))
    status = status._replace(**{k: v for k, v in changes.items() if k in status._fields})
    return [other._replace(status=status, **{k: v for k, v in changes.items() if k in other._fields})]


def _decided(others, *, address=2, t_s=0.0, own=OWN):
    law = TurnAway(PARAMS, TRACK, SLOTS, address, 1.5)
    law.decide(t_s, own, others)
    return law.course


def test_courses_are_even_and_to_both_sides():
    offsets = [course_offset_rad(index) for index in range(COURSES)]
    assert offsets[STRAIGHT_ON] == 0.0
    assert offsets == pytest.approx([-offset for offset in reversed(offsets)])
    assert np.ptp(np.diff(offsets)) < 1e-12


def test_a_vehicle_that_nothing_crosses_goes_straight_to_its_lane():
    assert _decided([]) == STRAIGHT_ON
    assert _decided(_others(position=(600.0, 600.0, 30.0))) == STRAIGHT_ON


def test_it_turns_away_from_one_that_comes_towards_it():
    assert _decided(_others()) != STRAIGHT_ON


@pytest.mark.parametrize(
    ("changes", "address", "turns"),
    [
        ({}, 2, True),
        ({"address": 3}, 2, False),
        ({"address": 3, "mode": Mode.INLANE}, 2, True),
        ({"position": (100.0, 30.0, 42.0), "depth_target_m": 42.0}, 2, False),
    ],
    ids=["lower address", "higher address", "in its lane", "in another layer"],
)
def test_to_which_neighbours_it_gives_way(changes, address, turns):
    assert (_decided(_others(**changes), address=address) != STRAIGHT_ON) == turns


@pytest.mark.parametrize(
    ("position", "velocity", "turns"),
    [
        ((100.0, 30.0, 30.0), (0.0, 0.0, 0.0), True),
        ((100.0, 30.0, 42.0), (0.0, 0.0, 0.0), False),
        ((140.0, 30.0, 30.0), (-1.5, 0.0, 0.0), True),
        ((140.0, 30.0, 30.0), (1.5, 0.0, 0.0), False),
    ],
    ids=["hovers ahead", "hovers below", "comes across", "leaves"],
)
def test_it_gives_way_to_a_vehicle_with_another_task_that_goes_straight_on(position, velocity, turns):
    other = NeighbourEstimate(9, position, velocity, np.eye(6), 2.0, position, velocity)
    law = TurnAway(PARAMS, TRACK, SLOTS, 1, 1.5)
    law.decide(0.0, OWN, [], [other])
    assert (law.course != STRAIGHT_ON) == turns


def test_it_decides_once_a_second_and_gives_up_in_its_lane():
    law = TurnAway(PARAMS, TRACK, SLOTS, 2, 1.5)
    law.decide(0.0, OWN, _others())
    first = law.course
    assert first != STRAIGHT_ON
    assert law.decide(0.5, OWN, []) == course_offset_rad(first)
    assert law.decide(1.0, OWN, []) == 0.0
    law.decide(2.0, OWN, _others())
    law.give_up()
    assert law.course == STRAIGHT_ON


def test_the_way_leads_into_the_lane_and_to_the_depth():
    way = np.empty((121, 3))
    roll_out(OWN._replace(depth_m=5.0), 1.5, 40.0, TRACK.rows, LAW, way)
    np.testing.assert_allclose(way[0], (100.0, 60.0, 5.0))
    assert way[-1, 1] == pytest.approx(15.0, abs=0.5)
    assert way[-1, 2] == pytest.approx(30.0)
    assert np.linalg.norm(np.diff(way[:, :2], axis=0), axis=1) == pytest.approx(1.5, abs=0.05)


def test_a_course_is_held_and_then_given_up():
    straight, held = np.empty((46, 3)), np.empty((46, 3))
    roll_out(OWN, 1.5, 40.0, TRACK.rows, LAW, straight)
    roll_out(OWN._replace(offset_rad=0.9, offset_s=20.0), 1.5, 40.0, TRACK.rows, LAW, held)
    away = np.linalg.norm(held - straight, axis=1)
    assert away[1] < 0.2
    assert away[20] > 10.0


def test_conflicts_are_worse_if_they_are_sooner_and_closer():
    own = np.zeros((46, 3))
    far, late = np.full((46, 3), 100.0), np.full((46, 3), 100.0)
    far[:, 2], late[:, 2] = 0.0, 0.0
    assert conflict(own, far, 14.0, 5.5, 45.0) == 0.0
    late[45] = (7.0, 0.0, 0.0)
    soon = late[::-1].copy()
    assert conflict(own, late, 14.0, 5.5, 45.0) == pytest.approx(0.25)
    assert conflict(own, soon, 14.0, 5.5, 45.0) == pytest.approx(0.5)
    assert conflict(own, np.add(soon, (0.0, 0.0, 6.0)), 14.0, 5.5, 45.0) == 0.0


def test_old_packets_are_uncertain_and_those_of_vehicles_in_lanes_are_not():
    assert uncertainty_m(10.0, PARAMS, avoids=False, in_lane=False) == pytest.approx(1.3)
    assert uncertainty_m(10.0, PARAMS, avoids=True, in_lane=False) == pytest.approx(2.3)
    assert uncertainty_m(1e4, PARAMS, avoids=True, in_lane=False) == 15.0
    assert uncertainty_m(1e4, PARAMS, avoids=True, in_lane=True) == 0.5
