"""Claims about modes, layers, slots and broadcasts of vehicles in lanes."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from auv_control.formations.shapes import SHAPES, shape_slots
from auv_flocking.lanes import broadcast, keeping_up
from auv_flocking.lanes.broadcast import Sent, after_slot
from auv_flocking.lanes.keeping_up import KeepingUp, kept_up
from auv_flocking.lanes.layers import check_layers, layer_depths, staggered
from auv_flocking.lanes.modes import ModeInputs, ModeState, Params, are_ready, is_heard, next_mode
from auv_flocking.lanes.status import FIELDS, LaneNeighbour, LaneStatus, Mode, apart_m, nearest

CYCLE_S = 10.0
PARAMS = Params()
T_S = 1000.0
CALM = ModeInputs(T_S, 0.5, 0.1, 0.2, 8.0, True, True)
LONG_AGO = ModeState(Mode.TRANSIT, 0.0, 990.0)
STATUS = LaneStatus(100.0, 5.0, 0.0, Mode.INLANE, False, 6, 30.0)

TABLE = [
    (Mode.TRANSIT, {}, Mode.INLANE),
    (Mode.TRANSIT, {"cross_track_m": -3.1}, Mode.TRANSIT),
    (Mode.TRANSIT, {"course_error_rad": 0.7}, Mode.TRANSIT),
    (Mode.TRANSIT, {"silence_s": 900.0}, Mode.INLANE),
    (Mode.INLANE, {}, Mode.FORM),
    (Mode.INLANE, {"cross_track_m": 50.0}, Mode.FORM),
    (Mode.INLANE, {"are_ready": False}, Mode.INLANE),
    (Mode.INLANE, {"is_heard": False}, Mode.INLANE),
    (Mode.INLANE, {"silence_s": 301.0}, Mode.LEAVE),
    (Mode.FORM, {"are_ready": False, "is_heard": False}, Mode.FORM),
    (Mode.FORM, {"silence_s": 299.0}, Mode.FORM),
    (Mode.FORM, {"silence_s": 301.0}, Mode.LEAVE),
    (Mode.LEAVE, {"silence_s": 400.0}, Mode.LOITER),
    (Mode.LEAVE, {"silence_s": 400.0, "layer_error_m": 1.6}, Mode.LEAVE),
    (Mode.LEAVE, {"silence_s": 5.0}, Mode.INLANE),
    (Mode.LOITER, {"silence_s": 900.0}, Mode.LOITER),
    (Mode.LOITER, {"silence_s": 5.0}, Mode.TRANSIT),
    (Mode.INLANE, {"has_ended": True}, Mode.LEAVE),
    (Mode.FORM, {"has_ended": True}, Mode.LEAVE),
    (Mode.LEAVE, {"has_ended": True, "silence_s": 5.0}, Mode.LOITER),
    (Mode.LOITER, {"has_ended": True, "silence_s": 5.0}, Mode.LOITER),
]


@pytest.mark.parametrize(("mode", "changes", "after"), TABLE)
def test_the_modes(mode, changes, after):
    state = next_mode(LONG_AGO._replace(mode=mode), CALM._replace(**changes), PARAMS, CYCLE_S)
    assert state.mode is after
    assert state.since_s == (T_S if after is not mode else 0.0)


def test_a_vehicle_is_in_its_lane_when_it_has_been_aligned_for_some_seconds():
    state = ModeState(Mode.TRANSIT, 0.0)
    waiting = CALM._replace(are_ready=False)
    for tick in range(60):
        state = next_mode(state, waiting._replace(t_s=0.1 * tick), PARAMS, CYCLE_S)
        assert state.mode is (Mode.TRANSIT if tick < 50 else Mode.INLANE)
    assert next_mode(state, CALM._replace(cross_track_m=9.0), PARAMS, CYCLE_S).aligned_since_s == math.inf


def test_a_vehicle_that_has_left_its_slot_loiters_no_sooner_than_it_has_settled():
    left = ModeState(Mode.LEAVE, T_S - 100.0, 0.0)
    silent = CALM._replace(silence_s=500.0)
    assert next_mode(left, silent, PARAMS, CYCLE_S).mode is Mode.LEAVE
    assert next_mode(left, silent._replace(t_s=T_S + 21.0), PARAMS, CYCLE_S).mode is Mode.LOITER


def test_slow_channels_make_the_fleet_more_patient():
    assert PARAMS.silence_max_s(10.0) == 300.0
    assert PARAMS.silence_max_s(64.0) == 512.0
    assert is_heard(29.9, 10.0)
    assert not is_heard(30.1, 10.0)


def _neighbour(address, age_s, status=STATUS):
    return LaneNeighbour(address, T_S - age_s, status, T_S, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("others", "t_s", "is_so"),
    [
        ([(_neighbour(2, 5.0), 1.0), (_neighbour(3, 5.0), -9.0)], T_S, True),
        ([(_neighbour(2, 5.0), 1.0), (_neighbour(3, 5.0), -11.0)], T_S, False),
        ([(_neighbour(2, 5.0), 1.0), (_neighbour(3, 91.0), -11.0)], T_S, True),
        (
            [(_neighbour(2, 5.0, STATUS._replace(mode=Mode.TRANSIT)), 1.0), (_neighbour(3, 5.0), 0.0)],
            T_S,
            False,
        ),
        ([(_neighbour(2, 5.0), 1.0)], 80.0, False),
        ([(_neighbour(2, 5.0), 1.0)], T_S, True),
    ],
    ids=[
        "all near",
        "one far",
        "one far and silent",
        "one in transit",
        "one not heard yet",
        "one never heard",
    ],
)
def test_when_neighbours_are_ready(others, t_s, is_so):
    assert are_ready(others, 3, t_s, PARAMS, CYCLE_S) == is_so


def test_slots_of_one_lane_are_deeper_going_aft():
    column = staggered(shape_slots("column", 3, 20.0), 6.0)
    assert column == ((0.0, 0.0, 0.0), (-20.0, 0.0, 6.0), (-40.0, 0.0, 12.0))
    assert {z for _, _, z in staggered(shape_slots("wedge", 5, 15.0), 6.0)} == {0.0}
    assert [z for _, _, z in staggered(shape_slots("diamond", 4, 15.0), 6.0)] == [0.0, 0.0, 0.0, 6.0]


def test_layers_are_above_and_below_in_turn():
    line = shape_slots("line", 5, 15.0)
    assert layer_depths(line, 30.0, 6.0) == (36.0, 24.0, 42.0, 18.0, 48.0)
    assert layer_depths(line, 10.0, 6.0, only_below=True) == (16.0, 22.0, 28.0, 34.0, 40.0)


@given(st.sampled_from(SHAPES), st.integers(2, 8), st.floats(6.0, 12.0), st.booleans())
def test_layers_are_apart_from_each_other_and_from_all_slots(shape, count, step_m, only_below):
    slots = staggered(shape_slots(shape, count, 20.0), 6.0)
    layers = layer_depths(slots, 100.0, step_m, only_below=only_below)
    check_layers(layers, slots, 100.0)
    gaps = [abs(a - b) for i, a in enumerate(layers) for b in layers[:i]]
    assert min(gaps) >= step_m - 1e-9


def test_layers_that_cannot_be_are_refused():
    line = shape_slots("line", 5, 15.0)
    with pytest.raises(
        ValueError, match=r"depth_m: 10.0 is not allowed; allowed: more than 12 m for 5 layers"
    ):
        layer_depths(line, 10.0, 6.0)
    with pytest.raises(
        ValueError, match=r"a gap of 5 m between the layer of vehicle 1 and the slot of vehicle 2"
    ):
        check_layers((35.0, 25.0, 40.0, 20.0, 45.0), line, 30.0)


EVENT = broadcast.Params()
FORM = STATUS._replace(mode=Mode.FORM)


@pytest.mark.parametrize(
    ("t_s", "status", "ahead_m", "repeats", "is_sent", "left"),
    [
        (510.0, FORM, 0.5, 0, False, 0),
        (510.0, FORM, -2.1, 0, True, 2),
        (510.0, FORM, 0.5, 2, True, 1),
        (510.0, FORM, 2.1, 1, True, 2),
        (561.0, FORM, 0.5, 0, True, 0),
        (510.0, STATUS, 0.5, 0, True, 2),
        (510.0, FORM._replace(mode=Mode.LOITER), 0.0, 0, True, 2),
    ],
    ids=["quiet", "event", "repeat", "event again", "heartbeat", "mode", "loiter"],
)
def test_when_a_vehicle_sends(t_s, status, ahead_m, repeats, is_sent, left):
    sent = Sent(500.0, FORM, repeats)
    result, after = after_slot(t_s, status, ahead_m, sent, EVENT)
    assert result == is_sent
    assert after is not None
    assert after.repeats == left
    assert after.time_s == (t_s if is_sent else 500.0)


def test_on_the_way_and_periodically_a_vehicle_always_sends():
    transit = FORM._replace(mode=Mode.TRANSIT)
    assert after_slot(501.0, transit, 0.0, Sent(500.0, transit, 0), EVENT)[0]
    assert after_slot(501.0, FORM, 0.0, Sent(500.0, FORM, 0), broadcast.Params(kind="periodic"))[0]
    assert after_slot(0.0, transit, 0.0, None, EVENT) == (True, Sent(0.0, transit, 2))


def test_the_threshold_falls_with_time():
    assert EVENT.threshold_at_m(100.0) == 7.0
    assert EVENT.threshold_at_m(1e4) == pytest.approx(2.0)
    assert math.isfinite(broadcast.Params(threshold_rate_ps=10.0).threshold_at_m(0.0))


def test_a_vehicle_that_cannot_keep_up_says_so_until_it_can():
    state = KeepingUp()
    flags = []
    for tick in range(3000):
        missing_mps = 0.1 if tick < 1200 else 0.0
        state = kept_up(state, missing_mps, -missing_mps, 0.1, keeping_up.Params())
        flags.append(state.is_limited)
    assert flags.index(True) == pytest.approx(60.0 * math.log(0.1 / 0.04) / 0.1, abs=3)
    reached_mps = 0.1 * -math.expm1(-2.0)
    assert flags.index(False, 1200) == pytest.approx(1200 + 60.0 * math.log(reached_mps / 0.02) / 0.1, abs=5)


def test_a_hull_that_gains_speed_keeps_up():
    state = KeepingUp()
    for tick in range(600):
        missing_mps = 0.4 * math.exp(-0.1 * tick / 5.0)
        state = kept_up(state, missing_mps, -missing_mps, 0.1, keeping_up.Params())
        assert not state.is_limited


@given(st.floats(-1e6, 1e6), st.floats(-200.0, 200.0))
def test_wrapped_numbers_are_those_nearest_to_the_own_ones(own_m, apart):
    gamma = FIELDS[0]
    carried = gamma.rounded(own_m + apart)
    assert nearest(carried, own_m, gamma) == pytest.approx(own_m + apart, abs=0.026)


@given(st.floats(-1e4, 1e4), st.floats(-100.0, 100.0), st.integers(-5, 5))
def test_differences_of_path_parameters_do_not_count_rounds(first_m, apart, rounds):
    assert apart_m(first_m + apart + rounds * 500.0, first_m, 500.0) == pytest.approx(apart, abs=1e-6)
    assert apart_m(first_m, 7.0, 0.0) == first_m - 7.0
