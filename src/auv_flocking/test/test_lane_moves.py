"""Claims about moves of a fleet of lanes to another shape: they keep distances, and have a least duration."""

import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.formations.shapes import SHAPES, least_distance_m
from auv_control.formations.switching import Transition
from auv_core.params import ConfigError, load
from auv_flocking.fleets._lane_settings import Params
from auv_flocking.lanes.moves import PEAK_RATIO, check_move, least_move_s, spare_of, ways

MODERATE = settings(max_examples=60, deadline=None)
SHAPE = st.sampled_from(SHAPES)
sides = st.floats(-90.0, 90.0)


def settings_of(**changes):
    return load(Params, changes, "params")


@MODERATE
@given(SHAPE, SHAPE, st.integers(2, 8))
def test_slots_that_move_keep_the_bound(shape, next_shape, count):
    params = settings_of(shape=shape, next_shape=next_shape, depth_m=200.0, switch_at_s=10.0, move_s=100.0)
    moving = params.ways(count)
    assert tuple(way.before for way in moving) == params.slots(count)
    bound_m = min(least_distance_m([way[k] for way in moving]) for k in (0, 1)) / math.sqrt(2.0)
    assert bound_m >= 15.0 / math.sqrt(2.0) - 1e-9
    for t_s in np.linspace(0.0, 120.0, 25):
        places = [way.at(t_s).position for way in moving]
        nearest_m = min(math.dist(a, b) for a, b in combinations(places, 2))
        assert nearest_m >= bound_m - 1e-9


@MODERATE
@given(st.tuples(sides, sides, sides), st.floats(0.01, 1.0))
def test_the_least_duration_is_that_of_the_largest_rate(after, slack):
    spare = spare_of(1.5, 0.7, 2.4)
    least_s = least_move_s(Transition((0.0, 0.0, 0.0), after), spare)
    way = Transition((0.0, 0.0, 0.0), after, 0.0, least_s + slack)
    check_move(way, spare)
    rates = np.abs([way.at(t_s).velocity for t_s in np.linspace(0.0, way.duration_s, 201)]).max(axis=0)
    assert (rates <= np.array(spare) + 1e-9).all()
    assert rates == pytest.approx(PEAK_RATIO * np.abs(after) / way.duration_s, rel=1e-3)


def test_a_move_that_is_too_short_is_refused():
    way = Transition((0.0, 0.0, 0.0), (-60.0, 0.0, 0.0), 0.0, 100.0)
    with pytest.raises(ValueError, match=r"^move_s: 100.0 is not allowed; allowed: at least 281 s"):
        check_move(way, spare_of(1.5, 0.7, 2.4))


def test_no_layer_is_at_the_depth_of_a_slot_of_either_shape():
    params = settings_of(shape="line", next_shape="column", depth_m=40.0)
    layers_m = params.layer_depths(5)
    slots_m = [40.0 + way[k][2] for way in params.ways(5) for k in (0, 1)]
    highest_m, lowest_m = min(slots_m), max(slots_m)
    assert lowest_m == 64.0
    assert all(layer_m <= highest_m - 6.0 or layer_m >= lowest_m + 6.0 for layer_m in layers_m)


def test_without_another_shape_slots_stay_to_the_last_bit():
    params = settings_of(shape="wedge", spacing_m=17.3)
    for way, slot in zip(params.ways(5), params.slots(5), strict=True):
        for t_s in (0.0, 0.1, 333.3):
            assert way.at(t_s).position == slot
            assert way.at(t_s).velocity == (0.0, 0.0, 0.0)


def test_a_switch_with_turning_away_is_refused():
    with pytest.raises(ConfigError, match=r"next_shape: 'column' is not allowed with turn_away\.kind"):
        settings_of(next_shape="column", turn_away={"kind": "intent_vo"})


def test_ways_are_in_the_order_of_addresses():
    before, after = ((0.0, 0.0, 0.0), (0.0, 20.0, 0.0)), ((-5.0, 20.0, 0.0), (-5.0, 0.0, 0.0))
    assert [way.after for way in ways(before, after, 0.0, 1.0)] == [after[1], after[0]]
