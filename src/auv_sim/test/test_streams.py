"""Claims about the random numbers that belong to events."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from auv_sim.seed_hash import LARGEST, first_word
from auv_sim.streams import Purpose, uniform

# Origin: computed once with NumPy 2.4; every recorded result rests on them, so they may never change.
KNOWN = {
    (1, 1, 2, 1): "0x1.aba847aa4407ap-2",
    (1, 1, 2, 2): "0x1.e7189833642a0p-4",
    (1, 2, 1, 1): "0x1.9cbd4865d996cp-1",
    (7, 1, 4, 120): "0x1.21bc6741611ccp-2",
    (2147483647, 254, 1, 1000000): "0x1.6369dbd59f6bcp-3",
}


def _numbers(count, *, seed=3, source=1, destination=2):
    return np.array([uniform(seed, Purpose.OUTAGE, source, destination, n) for n in range(1, count + 1)])


@pytest.mark.parametrize("event", KNOWN)
def test_numbers_are_the_same_on_every_machine(event):
    seed, source, destination, sequence = event
    assert uniform(seed, Purpose.OUTAGE, source, destination, sequence).hex() == KNOWN[event]


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**31 - 1), st.integers(1, 254), st.integers(1, 254), st.integers(1, 2**32 - 1))
def test_numbers_lie_in_the_unit_interval_and_repeat(seed, source, destination, sequence):
    number = uniform(seed, Purpose.OUTAGE, source, destination, sequence)
    assert 0.0 <= number < 1.0
    assert number == uniform(seed, Purpose.OUTAGE, source, destination, sequence)


def test_numbers_of_a_link_are_uniform():
    assert stats.kstest(_numbers(4000), "uniform").pvalue > 1e-3


def test_numbers_of_a_link_do_not_follow_from_the_one_before():
    numbers = _numbers(4000)
    assert abs(np.corrcoef(numbers[:-1], numbers[1:])[0, 1]) < 4.0 / np.sqrt(4000)


@pytest.mark.parametrize(
    "other", [{"seed": 4}, {"source": 5}, {"destination": 7}, {"source": 2, "destination": 1}]
)
def test_other_seeds_and_links_have_unrelated_numbers(other):
    assert abs(np.corrcoef(_numbers(2000), _numbers(2000, **other))[0, 1]) < 4.0 / np.sqrt(2000)


def test_purposes_keep_their_values():
    assert {purpose.name: int(purpose) for purpose in Purpose}["OUTAGE"] == 1
    assert len({int(purpose) for purpose in Purpose}) == len(Purpose)


@given(st.tuples(*[st.one_of(st.integers(0, 9), st.integers(0, LARGEST))] * 5))
def test_the_hash_is_that_of_numpys_seed_sequence(numbers):
    expected = int(np.random.SeedSequence(numbers).generate_state(1, np.uint64)[0])
    assert first_word(*numbers) == expected
