"""Claims about what vehicle and relay take in real time: fresh and possible inputs, whatever comes first."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from auv_core.freshness import Newest
from auv_core.messages import VehicleState, Wrench
from auv_sim.command_watch import BAD_COMMAND, STALE_COMMAND, CommandWatch
from auv_sim.relay.state_watch import StateWatch

PERIOD_S = 0.1
PUSH = Wrench((1.0, 0.0, 0.0, 0.0, 0.0, 0.0))
TICKS = st.one_of(st.integers(0, 60), st.integers(-(2**63), 2**63 - 1))


def state(tick, **changes):
    return VehicleState(tick, (0.0, 0.0, 10.0), (1.0, 0.0, 0.0, 0.0), (0.0,) * 6)._replace(**changes)


def test_a_command_that_grows_old_is_not_acted_on_until_a_fresh_one_comes():
    watch = CommandWatch(0.5, PERIOD_S)
    watch.hear(PUSH, 10, 10)
    assert [watch.command(tick) for tick in (10, 15)] == [PUSH, PUSH]
    assert watch.command(16) is None
    assert watch.resting == f"{STALE_COMMAND}: 0.6 s old, allowed: 0.5 s"
    watch.hear(PUSH, 17, 17)
    assert (watch.command(17), watch.resting) == (PUSH, "")


def test_a_vehicle_that_waits_for_its_first_command_says_so_when_it_is_late():
    watch = CommandWatch(0.5, PERIOD_S)
    watch.newest.start(100)
    assert (watch.command(105), watch.resting) == (None, "")
    assert watch.command(106) is None
    assert watch.resting == f"{STALE_COMMAND}: 0.6 s old, allowed: 0.5 s"


def test_a_command_that_cannot_be_used_lets_the_actuators_rest():
    watch = CommandWatch(0.5, PERIOD_S)
    watch.hear(PUSH, 0, 0)
    watch.hear(None, 1, 1)
    assert (watch.command(1), watch.resting) == (None, BAD_COMMAND)


def test_an_input_of_a_far_tick_blinds_nobody():
    newest: Newest[Any] = Newest(0.5, PERIOD_S)
    assert newest.hear("one", 10, 10)
    assert not newest.hear("far", 10**9, 11)
    assert newest.hear("two", 11, 11)
    assert (newest.value, newest.dropped) == ("two", 1)
    assert newest.dropped_words == "tick 1000000000 at tick 11: 99999998.9 s in the future, allowed: 0.5 s"


def test_a_source_that_starts_anew_counts_once_it_has_caught_up():
    newest: Newest[Any] = Newest(0.5, PERIOD_S)
    newest.hear("old life", 1000, 1000)
    assert not newest.hear("new life", 0, 1001)
    assert newest.hear("new life", 20, 1010)
    assert newest.why_stale(1010) == "99.0 s old, allowed: 0.5 s"
    assert newest.hear("new life", 1020, 1021)
    assert newest.why_stale(1021) == ""


@given(st.lists(TICKS, max_size=30))
def test_whatever_came_a_fresh_input_is_the_newest_at_once(ticks):
    newest: Newest[Any] = Newest(0.5, PERIOD_S)
    for now_tick, tick in enumerate(ticks):
        newest.hear(tick, tick, now_tick)
        assert newest.tick <= now_tick + 5
    assert newest.hear("fresh", len(ticks), len(ticks))
    assert newest.why_stale(len(ticks)) == ""


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (state(3, position=(math.nan, 0.0, 0.0)), "auv_2: a number that is none: nan"),
        (state(3, attitude=(0.0, 0.0, 0.0, 0.0)), "auv_2: attitude of length 0, allowed: 1"),
        (state(10**9), "auv_2: tick 1000000000 at tick 3: 99999999.7 s in the future, allowed: 0.5 s"),
    ],
    ids=["nan", "attitude", "tick"],
)
def test_a_relay_leaves_out_states_that_are_none_and_says_whose(bad, words):
    watch = StateWatch(["auv_1", "auv_2"], 0.5, PERIOD_S)
    assert watch.hear(1, state(2), 2)
    assert not watch.hear(1, bad, 3)
    assert (watch.left_out, watch.left_out_words) == (1, words)
    assert watch.why_stale(1, 7) == ""
    assert watch.why_stale(1, 8) == "state of auv_2 0.6 s old, allowed: 0.5 s"
    assert watch.may_send(1, 7, 1)
    assert not watch.may_send(1, 8, 1)
    assert watch.packets_unsent == 1


def test_a_relay_that_waits_names_the_state_that_it_left_out():
    watch = StateWatch(["auv_1", "auv_2"], 0.5, PERIOD_S)
    assert watch.explained("/auv_2/vehicle_node") == "/auv_2/vehicle_node"
    assert not watch.hear(1, state(30), 10)
    left_out = "left out: auv_2: tick 30 at tick 10: 2.0 s in the future, allowed: 0.5 s"
    assert watch.explained("/auv_2/vehicle_node") == f"/auv_2/vehicle_node; {left_out}"
    assert watch.explained("") == ""
