"""Claims about the flocking law: the thesis's equations by hand, and every deviation behind its parameter."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.references import PathPoint
from auv_flocking.flocking import NOTHING_HEARD, FlockVelocity, Member, View
from auv_flocking.flocking.potential import Flocking, Params
from auv_flocking.neighbours.estimates import NeighbourEstimate
from auv_flocking.separation import mathematical

MODERATE = settings(max_examples=60, deadline=None)
SEPARATION = mathematical.Separation(mathematical.Params())
PARAMS = Params(spacing_m=2.0, cohesion_gain_ps=2.0, path_gain_ps=0.5)
VIEW = View(
    position=(1.0, 2.0, 3.0),
    centre=(2.0, 2.0, 3.0),
    flock_velocity=(0.0, 0.3, 0.0),
    neighbours=((2.0, 2.0, 3.0),),
    obstacles=(((1.0, 2.0, 4.0), 2.0),),
    path=PathPoint((1.0, 4.0, 3.0), (0.1, 0.0, 0.0)),
)
# By hand: F_c = 2 (1, 0, 0), F_d = 0.5 (0, 2, 0); neighbour and obstacle at r = 1 with d = 2 push by 6.
COHESION = np.array([2.0, 0.0, 0.0])
PATH = np.array([0.0, 1.0, 0.0])
APART = np.array([-6.0, 0.0, 0.0])
OBSTACLE = np.array([0.0, 0.0, -6.0])
AHEAD = np.array([0.1, 0.0, 0.0])

POINTS = st.tuples(*[st.floats(-20.0, 20.0)] * 3)
VIEWS = st.builds(
    View,
    position=POINTS,
    centre=POINTS,
    flock_velocity=POINTS,
    neighbours=st.lists(POINTS, max_size=4).map(tuple),
    obstacles=st.lists(st.tuples(POINTS, st.floats(0.5, 4.0)), max_size=2).map(tuple),
    path=st.builds(PathPoint, POINTS, POINTS),
    sensed=st.just(()),
)


def _law(is_leader=True, **changes):
    return Flocking(replace(PARAMS, **changes), SEPARATION, Member(is_leader))


def _estimate(flock_velocity, stamp_s=0.0):
    zero = (0.0, 0.0, 0.0)
    return NeighbourEstimate(2, zero, zero, np.eye(6), 0.0, zero, flock_velocity, stamp_s)


def _belief(law, view, heard):
    estimates = [_estimate(velocity) for velocity in heard]
    return law.flock_velocity(0.0, view.path, view.centre, NOTHING_HEARD, estimates).velocity


def test_leader_follows_eq_5_22_and_5_40():
    np.testing.assert_allclose(_law().velocity(VIEW), COHESION + PATH + APART + OBSTACLE + AHEAD)


def test_printed_follower_follows_eq_5_43_without_the_paths_velocity():
    np.testing.assert_allclose(_law(is_leader=False).velocity(VIEW), COHESION + PATH + APART + OBSTACLE)


def test_blind_follower_follows_eq_5_24():
    law = _law(is_leader=False, followers="blind")
    np.testing.assert_allclose(law.velocity(VIEW), COHESION + APART + OBSTACLE)


def test_bandwidth_scales_the_feedback_and_not_the_feedforward():
    law = _law(bandwidth_ratio=0.05)
    np.testing.assert_allclose(law.velocity(VIEW), 0.05 * (COHESION + PATH + APART + OBSTACLE) + AHEAD)


def test_a_leader_that_steers_the_centre_does_not_pull_itself_to_the_path():
    law = _law(leader_steers="centre")
    np.testing.assert_allclose(law.velocity(VIEW), COHESION + APART + OBSTACLE + AHEAD)


def test_a_leader_that_steers_the_centre_believes_the_flock_to_go_to_the_path():
    law = _law(leader_steers="centre")
    expected = AHEAD + 0.5 * (np.array(VIEW.path.position) - VIEW.centre)
    np.testing.assert_allclose(_belief(law, VIEW, [(9.0, 9.0, 9.0)]), expected)


def test_a_leader_that_steers_itself_believes_the_paths_velocity():
    assert _belief(_law(), VIEW, [(9.0, 9.0, 9.0)]) == (0.1, 0.0, 0.0)


def test_a_follower_takes_the_mean_of_what_is_believed():
    law = _law(is_leader=False)
    heard = [(0.3, 0.0, 0.0), (0.0, 0.0, 0.6)]
    assert _belief(law, VIEW, heard) == pytest.approx((0.1, 0.0, 0.2))
    assert _belief(law, VIEW, []) == (0.0, 0.0, 0.0)


def test_a_belief_carries_the_stamp_of_the_newest_leader_heard():
    view, own = VIEW, FlockVelocity((0.0, 0.0, 0.0), 3.0)
    heard = [_estimate((0.1, 0.0, 0.0), 5.0), _estimate((0.1, 0.0, 0.0), 4.0)]
    follower, leader = _law(is_leader=False), _law()
    assert follower.flock_velocity(9.0, view.path, view.centre, own, heard).stamp_s == 5.0
    assert follower.flock_velocity(9.0, view.path, view.centre, own, []).stamp_s == 3.0
    assert leader.flock_velocity(9.0, view.path, view.centre, own, heard).stamp_s == 9.0


@pytest.mark.parametrize("is_leader", [True, False])
def test_flock_feedforward_gives_everybody_the_flocks_velocity(is_leader):
    with_it = _law(is_leader, feedforward="flock").velocity(VIEW)
    without = np.array(_law(is_leader).velocity(VIEW)) - (AHEAD if is_leader else 0.0)
    np.testing.assert_allclose(with_it, without + VIEW.flock_velocity)


@MODERATE
@given(VIEWS, POINTS, POINTS, st.lists(POINTS, max_size=4), st.sampled_from(["leader", "flock"]))
def test_a_blind_follower_never_depends_on_the_path(view, position, velocity, heard, feedforward):
    law = _law(is_leader=False, followers="blind", feedforward=feedforward)
    other = PathPoint(position, velocity)
    assert law.velocity(view) == law.velocity(view._replace(path=other))
    assert _belief(law, view, heard) == _belief(law, view._replace(path=other), heard)


@MODERATE
@given(VIEWS, st.booleans(), st.floats(0.01, 2.0))
def test_the_limit_bounds_the_feedback_and_keeps_its_direction(view, is_leader, limit_mps):
    free = np.array(_law(is_leader, feedforward="flock").velocity(view)) - view.flock_velocity
    held = _law(is_leader, feedforward="flock", correction_limit_mps=limit_mps).velocity(view)
    held = np.array(held) - view.flock_velocity
    assert np.linalg.norm(held) <= limit_mps + 1e-9
    np.testing.assert_allclose(np.cross(held, free), 0.0, atol=1e-9 * float(1.0 + np.linalg.norm(free)))
    if np.linalg.norm(free) < limit_mps * (1.0 - 1e-9):
        np.testing.assert_allclose(held, free, atol=1e-12)


@MODERATE
@given(VIEWS, st.floats(0.01, 2.0))
def test_the_limit_bounds_the_leaders_steering(view, limit_mps):
    law = _law(leader_steers="centre", correction_limit_mps=limit_mps)
    steer = np.subtract(_belief(law, view, []), view.path.velocity)
    assert np.linalg.norm(steer) <= limit_mps + 1e-9


@MODERATE
@given(VIEWS, st.booleans())
def test_the_order_of_neighbours_hardly_matters(view, is_leader):
    law = _law(is_leader)
    turned = view._replace(neighbours=tuple(reversed(view.neighbours)))
    forward = law.velocity(view)
    np.testing.assert_allclose(
        law.velocity(turned), forward, rtol=1e-9, atol=1e-9 * (1.0 + math.hypot(*forward))
    )


def test_an_obstacle_is_met_with_the_laws_own_way_where_it_has_one():
    class Odd:
        def velocity(self, own, other, spacing_m):
            return (1.0, 0.0, 0.0)

        def obstacle_velocity(self, own, obstacle, spacing_m):
            return (0.0, 7.0, spacing_m)

    law = Flocking(replace(PARAMS, followers="blind"), Odd(), Member())
    np.testing.assert_allclose(law.velocity(VIEW), COHESION + np.array([1.0, 7.0, 2.0]))


def test_the_defaults_are_the_thesiss_law():
    defaults = Params()
    assert (defaults.spacing_m, defaults.cohesion_gain_ps, defaults.path_gain_ps) == (2.0, 1.0, 1.0)
    assert (defaults.bandwidth_ratio, defaults.followers, defaults.leader_steers) == (
        1.0,
        "printed",
        "itself",
    )
    assert defaults.feedforward == "leader"
