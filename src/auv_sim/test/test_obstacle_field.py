"""Claims about obstacles in the water: where they are, and that sonars see them like hulls."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from auv_core.messages import VehicleState
from auv_core.params import Section
from auv_sim.acoustics.sonar import active
from auv_sim.obstacle_field import ObstacleConfig, ObstacleField
from auv_sim.obstacles import shuttle, straight

HERE = (1.0, -2.0, 5.0)
SURE = active.Params(range_sd_m=0.0, angle_sd_rad=0.0, detection_prob=1.0)
PERIOD_S = 0.1
TIMES_S = st.floats(0.0, 1e4)


def _obstacle(kind, params):
    return ObstacleConfig(position_ned_m=HERE, known=False, motion=Section(kind, params))


def _hull(position):
    return VehicleState(0, position, (1.0, 0.0, 0.0, 0.0), (0.0,) * 6)


@given(TIMES_S)
def test_an_obstacle_stays_where_it_is_unless_it_has_a_motion(t_s):
    assert ObstacleField([ObstacleConfig(position_ned_m=HERE)]).at(t_s) == (HERE,)


@given(TIMES_S)
def test_a_straight_motion_has_its_velocity(t_s):
    params = straight.Params(velocity_ned_mps=(0.1, -0.2, 0.0))
    ((north, east, down),) = ObstacleField([_obstacle("straight", params)]).at(t_s)
    assert (north, east, down) == pytest.approx((1.0 + 0.1 * t_s, -2.0 - 0.2 * t_s, 5.0))


@given(st.floats(1.0, 1e3), st.integers(0, 5))
def test_a_shuttle_is_at_its_ends_at_rest_and_in_the_middle_at_its_top_speed(round_s, rounds):
    motion = shuttle.Motion(shuttle.Params(span_ned_m=(0.0, 4.0, 0.0), round_s=round_s))
    begin_s = rounds * round_s
    assert motion.offset(begin_s)[1] == pytest.approx(0.0, abs=1e-9)
    assert motion.offset(begin_s + 0.5 * round_s)[1] == pytest.approx(4.0)
    step_s = 1e-4 * round_s
    before, after = (motion.offset(begin_s + 0.25 * round_s + s)[1] for s in (-step_s, step_s))
    assert (after - before) / (2.0 * step_s) == pytest.approx(math.pi * 4.0 / round_s, rel=1e-4)


def test_a_contact_does_not_tell_an_obstacle_from_a_hull():
    own, place = _hull((0.0, 0.0, 0.0)), (3.0, 4.0, 0.0)
    (of_hull,) = active.Sonar(SURE, 1).contacts(1, 0, PERIOD_S, [own, _hull(place)])
    (of_obstacle,) = active.Sonar(SURE, 1).contacts(1, 0, PERIOD_S, [own], [place])
    assert of_hull == of_obstacle


def test_obstacles_out_of_reach_or_out_of_view_are_not_seen():
    own = _hull((0.0, 0.0, 0.0))
    ahead_only = active.Params(detection_prob=1.0, horizontal_view_rad=1.0)
    assert active.Sonar(SURE, 1).contacts(1, 0, PERIOD_S, [own], [(10.1, 0.0, 0.0)]) == ()
    assert active.Sonar(ahead_only, 1).contacts(1, 0, PERIOD_S, [own], [(-3.0, 0.0, 0.0)]) == ()
    assert active.Sonar(ahead_only, 1).contacts(1, 0, PERIOD_S, [own], [(3.0, 0.0, 0.0)])


def test_obstacles_do_not_change_the_luck_of_hulls_nor_of_each_other():
    fleet, rocks = [_hull((0.0, 0.0, 0.0)), _hull((5.0, 0.0, 0.0))], [(0.0, 4.0, 0.0), (0.0, -6.0, 0.0)]
    params = active.Params(detection_prob=0.7)
    for tick in range(0, 500, 5):
        seen = [
            set(active.Sonar(params, 1).contacts(1, tick, PERIOD_S, fleet, rocks[:count]))
            for count in range(3)
        ]
        assert seen[0] <= seen[1] <= seen[2]


def test_the_share_of_pings_that_show_an_obstacle_is_the_detection_probability():
    sonar, own, rock = (
        active.Sonar(active.Params(detection_prob=0.7), 3),
        [_hull((0.0,) * 3)],
        [(3.0, 0.0, 0.0)],
    )
    shown = [bool(sonar.contacts(1, tick, PERIOD_S, own, rock)) for tick in range(0, 20000, 5)]
    assert sum(shown) / len(shown) == pytest.approx(0.7, abs=4.0 * math.sqrt(0.7 * 0.3 / len(shown)))
