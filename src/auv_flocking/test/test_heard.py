"""Claims about what a report says about hearing."""

from hypothesis import given
from hypothesis import strategies as st

from auv_flocking.heard import BITS, CODES, bit_of, class_of_all, mask_of, within_s

FLEETS = st.integers(1, 40)
AGES = st.dictionaries(st.integers(1, 40), st.floats(0.0, 400.0))
CLASSES = st.integers(0, CODES - 1)


@given(AGES, FLEETS, FLEETS, CLASSES)
def test_a_set_bit_is_true_of_every_vehicle_that_shares_it(ages_s, own, fleet_size, code):
    mask = mask_of(ages_s, own, fleet_size, code)
    assert 0 <= mask < 1 << BITS
    for address in set(range(1, fleet_size + 1)) - {own}:
        is_heard = address in ages_s and ages_s[address] <= within_s(code)
        assert is_heard or not mask & bit_of(address)
        if fleet_size <= BITS:
            assert is_heard == bool(mask & bit_of(address))


@given(AGES, FLEETS, FLEETS, st.integers(0, CODES - 2))
def test_an_older_class_says_it_of_no_fewer(ages_s, own, fleet_size, code):
    younger, older = (mask_of(ages_s, own, fleet_size, each) for each in (code, code + 1))
    assert younger & older == younger


def test_alone_no_bit_is_set():
    assert mask_of({}, 1, 1, 0) == 0


@given(st.floats(1.0, 60.0), st.floats(60.1, 1e4))
def test_a_lost_vehicle_does_not_make_the_class_coarse(age_s, lost_s):
    assert class_of_all({1: age_s, 2: lost_s}, 60.0) == class_of_all({1: age_s})


@given(AGES)
def test_the_class_of_all_holds_all_ages_if_any_class_does(ages_s):
    code = class_of_all(ages_s)
    assert code == CODES - 1 or max(ages_s.values(), default=0.0) <= within_s(code)
    assert code == 0 or max(ages_s.values()) > within_s(code - 1)


def test_classes_are_from_one_second_to_three_minutes():
    assert within_s(0) == 1.0
    assert 181.0 < within_s(CODES - 1) < 181.1
