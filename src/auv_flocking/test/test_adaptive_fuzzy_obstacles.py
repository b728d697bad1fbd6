"""Claims about the adaptive fuzzy separation for waters with obstacles."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.references import PathPoint
from auv_flocking.flocking import Member, View, communication_aware, potential
from auv_flocking.separation import adaptive_fuzzy
from auv_flocking.separation.adaptive_fuzzy_obstacles import Params, Separation

MODERATE = settings(max_examples=60, deadline=None)
ORIGIN = (0.0, 0.0, 0.0)
SAFETY_M = 2.0
ERRORS = st.lists(st.floats(-2.0, 20.0), max_size=4)


def _pulled_beside_an_obstacle(law, pull_mps, duration_s=120.0, period_s=0.1):
    """Return the distances (m) of a point that a steady velocity pulls to an obstacle at the origin."""
    place, distances_m = (6.0, 0.0, 0.0), []
    for _ in range(round(duration_s / period_s)):
        push = law.obstacle_velocity(place, ORIGIN, SAFETY_M)
        law.adapt_to_obstacles([math.dist(place, ORIGIN) - SAFETY_M], period_s)
        place = (place[0] + period_s * (push[0] - pull_mps), place[1], place[2])
        distances_m.append(place[0])
    return np.array(distances_m)


@pytest.mark.parametrize("pull_mps", [0.3, 0.6, 1.0])
def test_it_holds_the_safety_distance_against_a_pull(pull_mps):
    held_m = _pulled_beside_an_obstacle(Separation(Params()), pull_mps)
    assert held_m[-300:] == pytest.approx(SAFETY_M, abs=0.02)
    at_rest_m = _pulled_beside_an_obstacle(Separation(Params(obstacle_rate_ps2=0.0)), pull_mps)
    assert at_rest_m[-1] < SAFETY_M - 0.1
    assert at_rest_m.min() <= held_m.min() + 1e-9


def test_vehicles_and_obstacles_at_first_are_met_as_by_adaptive_fuzzy():
    plain, law = adaptive_fuzzy.Separation(adaptive_fuzzy.Params()), Separation(Params())
    for each in (plain, law):
        each.adapt([1.7], SAFETY_M, 0.1)
    for x in np.linspace(0.1, 8.0, 50).tolist():
        own = (x, 0.3, -0.2)
        assert law.velocity(own, ORIGIN, SAFETY_M) == plain.velocity(own, ORIGIN, SAFETY_M)
        assert law.obstacle_velocity(own, ORIGIN, SAFETY_M) == plain.obstacle_velocity(own, ORIGIN, SAFETY_M)


@MODERATE
@given(st.lists(ERRORS, max_size=40), st.floats(0.01, 5.0), st.floats(0.05, 20.0))
def test_an_obstacle_never_attracts_and_the_shift_is_bounded(history, dt_s, range_m):
    law = Separation(Params(obstacle_rate_ps2=3.0))
    for errors_m in history:
        law.adapt_to_obstacles(errors_m, dt_s)
        assert -Params().obstacle_shift_max_mps <= law.obstacle_shift_mps <= 0.0
    assert law.obstacle_velocity((range_m, 0.0, 0.0), ORIGIN, SAFETY_M)[0] >= 0.0


@MODERATE
@given(st.lists(ERRORS, min_size=1, max_size=40))
def test_the_push_has_no_step(history):
    law = Separation(Params())
    for errors_m in history:
        law.adapt_to_obstacles(errors_m, 1.0)
    ranges_m = np.linspace(1.0, 8.0, 2001)
    pushes = [law.obstacle_velocity((x, 0.0, 0.0), ORIGIN, SAFETY_M)[0] for x in ranges_m.tolist()]
    assert np.abs(np.diff(pushes)).max() < 0.05


def test_it_forgets_where_no_obstacle_is_near():
    law = Separation(Params())
    for _ in range(100):
        law.adapt_to_obstacles([-0.5], 0.1)
    learnt_mps = law.obstacle_shift_mps
    assert learnt_mps == pytest.approx(-1.5)
    for _ in range(200):
        law.adapt_to_obstacles([3.0], 0.1)
    assert law.obstacle_shift_mps == pytest.approx(learnt_mps / math.e, rel=1e-6)


@pytest.mark.parametrize("law", [potential, communication_aware], ids=["potential", "communication_aware"])
def test_flocking_laws_let_it_learn_from_obstacles(law):
    separation = Separation(Params())
    made = law.Flocking(law.Params(), separation, Member(is_leader=True))
    view = View(
        ORIGIN, ORIGIN, ORIGIN, ((1.5, 0.0, 0.0),), (((0.0, 1.6, 0.0), 2.0),), PathPoint(ORIGIN, ORIGIN)
    )
    made.adapt(view, 0.1)
    assert separation.obstacle_shift_mps == pytest.approx(0.1 * Params().obstacle_rate_ps2 * -0.4)
    assert separation.shift_mps < 0.0
