"""A vehicle that crosses the depth of another one stops before it, and steps aside first."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from auv_flocking.flocking import Member
from auv_flocking.flocking._layers import aside, crossing_margin_m, layering, levelled, own_layer
from auv_flocking.flocking.communication_aware import Params

PARAMS = Params(layer_depth_m=10.0, layer_m=1.5)
HIGHEST_M, LOWEST_M = 7.75, 12.25
KEEP_M = 1.5


def _of(address, depth_m):
    own = own_layer(PARAMS, Member(False, address, 4))
    assert own is not None
    return layering(own, depth_m, may_leave=True)


def _aside(own, other, address, age_s, *, own_address=1):
    return aside(own, other, address, age_s, KEEP_M, _of(own_address, own[2]))


@pytest.mark.parametrize(("depth_m", "is_in"), [(7.75, 1), (8.0, 1), (7.4, 0), (9.0, 0), (20.0, 0)])
def test_the_first_address_has_the_highest_layer(depth_m, is_in):
    layer = _of(1, depth_m)
    assert (layer.is_in, layer.highest_m, layer.pitch_m) == (is_in, HIGHEST_M, 1.5)
    assert math.copysign(1.0, layer.sinking_mps) == math.copysign(1.0, HIGHEST_M - depth_m)


@given(sigma_m=st.floats(0.0, 50.0), age_s=st.floats(0.0, 1e4), older_s=st.floats(0.0, 100.0))
def test_a_vehicle_crosses_farther_from_older_news_up_to_a_limit(sigma_m, age_s, older_s):
    margin_m = crossing_margin_m(sigma_m, age_s)
    assert 0.0 <= margin_m <= crossing_margin_m(sigma_m, age_s + older_s) <= 2.5
    assert crossing_margin_m(0.5, 10.0) == pytest.approx(1.5)


def test_a_vehicle_steps_aside_for_one_that_is_ahead_in_its_way():
    """From 12 m up to the layer at 7.75 m; the neighbour's layer is 9.25 m."""
    np.testing.assert_allclose(_aside((0.0, 0.5, 10.2), (0.0, 0.0, 9.25), 2, 0.0), (0.0, 0.2, 0.0))
    assert _aside((0.0, 0.5, 8.9), (0.0, 0.0, 9.25), 2, 0.0) == (0.0, 0.0, 0.0), "it is behind"
    assert _aside((0.0, 1.6, 10.2), (0.0, 0.0, 9.25), 2, 0.0) == (0.0, 0.0, 0.0), "it is at the side"


@pytest.mark.parametrize(("age_s", "steps"), [(2.0, False), (20.0, True)])
def test_a_neighbour_may_have_gone_towards_its_layer_since_it_was_heard(age_s, steps):
    """Last heard at 5 m, with a layer at 12.25 m: after 20 s it may be at 10 m, on the way of the other."""
    step = _aside((0.5, 0.0, 11.0), (0.0, 0.0, 5.0), 4, age_s)
    assert (step != (0.0, 0.0, 0.0)) == steps


def test_in_its_layer_a_vehicle_steps_aside_only_for_one_that_may_pass_through():
    own = (0.5, 0.0, HIGHEST_M)
    assert _aside(own, (0.0, 0.0, 9.25), 2, 60.0) == (0.0, 0.0, 0.0)
    assert _aside(own, (0.0, 0.0, 5.0), 2, 20.0)[0] == pytest.approx(0.2)


@given(own=st.tuples(*[st.floats(-3.0, 3.0)] * 2, st.floats(1.0, 20.0)), age_s=st.floats(0.0, 200.0))
def test_a_step_is_level_away_from_the_neighbour_and_bounded(own, age_s):
    dx, dy, dz = _aside(own, (0.0, 0.0, 10.0), 3, age_s)
    assert dz == 0.0
    assert math.hypot(dx, dy) in (0.0, pytest.approx(0.2))
    assert dx * own[0] + dy * own[1] >= -1e-9


@given(angle_rad=st.floats(-1.0, 1.0), bound_mps=st.floats(-0.3, 0.3), sinking_mps=st.floats(-0.25, 0.25))
def test_a_levelled_half_space_is_the_same_for_a_vehicle_that_keeps_its_depth(
    angle_rad, bound_mps, sinking_mps
):
    normal = (math.cos(angle_rad), 0.0, math.sin(angle_rad))
    level, level_mps = levelled(normal, bound_mps, sinking_mps)
    on_it = (level_mps * level[0], level_mps * level[1], sinking_mps)
    assert np.dot(normal, on_it) == pytest.approx(bound_mps, abs=1e-12)
    assert levelled((0.3, 0.0, math.sqrt(0.91)), bound_mps, sinking_mps)[1] == -math.inf
