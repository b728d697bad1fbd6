"""Claims about the lock-step barrier."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_sim.relay.barrier import Barrier


def _started(count):
    barrier = Barrier(count)
    for vehicle in range(count):
        assert barrier.state(vehicle, 0)
    assert barrier.advance() == 0
    return barrier


def _answers(count, tick):
    return [("state", vehicle, tick + 1) for vehicle in range(count)] + [
        ("outbox", vehicle, tick) for vehicle in range(count)
    ]


@settings(max_examples=80, deadline=None)
@given(st.integers(1, 5).flatmap(lambda n: st.tuples(st.just(n), st.permutations(_answers(n, 0)))))
def test_a_tick_is_complete_with_the_last_answer_in_every_order(case):
    count, answers = case
    barrier = _started(count)
    for kind, vehicle, tick in answers:
        assert not barrier.complete
        assert getattr(barrier, kind)(vehicle, tick)
    assert barrier.complete
    assert barrier.owed() == []
    assert barrier.advance() == 1
    assert not barrier.complete


@settings(max_examples=80, deadline=None)
@given(
    st.lists(
        st.tuples(st.sampled_from(["state", "outbox"]), st.integers(0, 2), st.integers(-1, 4)), max_size=30
    )
)
def test_answers_for_other_ticks_and_second_answers_count_for_nothing(answers):
    barrier = _started(3)
    given_once = set()
    for kind, vehicle, tick in answers:
        is_owed = tick == (1 if kind == "state" else 0) and (kind, vehicle) not in given_once
        assert getattr(barrier, kind)(vehicle, tick) is is_owed
        if is_owed:
            given_once.add((kind, vehicle))
    assert barrier.complete is (len(given_once) == 6)


def test_before_the_first_tick_only_states_are_owed():
    barrier = Barrier(2)
    assert barrier.tick == -1
    assert barrier.owed() == [("vehicle_node", 0), ("vehicle_node", 1)]
    assert not barrier.outbox(0, -1)


def test_of_a_silent_pair_the_agent_is_named():
    barrier = _started(3)
    barrier.outbox(0, 0)
    barrier.outbox(1, 0)
    barrier.state(0, 1)
    assert barrier.owed() == [("agent_node", 2), ("vehicle_node", 1)]


def test_dropped_vehicles_are_not_waited_for_any_more():
    barrier = _started(3)
    barrier.drop([1])
    for vehicle in (0, 2):
        barrier.state(vehicle, 1)
        barrier.outbox(vehicle, 0)
    assert barrier.complete
    barrier.advance()
    assert barrier.owed() == [("agent_node", 0), ("agent_node", 2)]
    assert not barrier.state(1, 2)


@pytest.mark.parametrize("dropped", [[0, 1, 2], [0, 1]])
def test_dropping_the_last_that_owed_completes_the_tick(dropped):
    barrier = _started(3)
    barrier.state(2, 1)
    barrier.outbox(2, 0)
    barrier.drop(dropped)
    assert barrier.complete
