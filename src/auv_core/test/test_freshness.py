"""Claims about inputs that are too old, and about valid states."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from auv_core.freshness import age_limit_s, why_not_now
from auv_core.messages import VehicleState
from auv_core.state_checks import checked_state

GOOD = VehicleState(0, (1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0), (0.1, 0.0, 0.0, 0.0, 0.0, 0.0))
ANYTHING = st.floats(width=64)


@pytest.mark.parametrize(
    ("age_s", "words"),
    [
        (0.0, ""),
        (5 * 0.1, ""),
        (0.8 - 0.3, ""),
        (0.6, "0.6 s old, allowed: 0.5 s"),
        (-0.4, ""),
        (-2.1, "2.1 s in the future, allowed: 0.5 s"),
    ],
)
def test_an_input_is_used_up_to_its_age(age_s, words):
    assert why_not_now(age_s, age_limit_s(0.5, 0.1)) == words


def test_two_control_periods_are_never_too_old():
    assert why_not_now(2.0, age_limit_s(0.5, 1.0)) == ""
    assert why_not_now(2.1, age_limit_s(0.5, 1.0)) != ""


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"is_valid": False}, "marked as not valid"),
        ({"position": (math.nan, 0.0, 0.0)}, "a number that is none: nan"),
        ({"nu": (0.0, 0.0, 0.0, 0.0, 0.0, -math.inf)}, "a number that is none: -inf"),
        ({"position_sd_m": -1.0}, "negative deviation: -1 m, 0 rad"),
        ({"heading_sd_rad": -0.1}, "negative deviation: 0 m, -0.1 rad"),
        ({"attitude": (0.0, 0.0, 0.0, 0.0)}, "attitude of length 0, allowed: 1"),
        ({"attitude": (0.5, 0.0, 0.0, 0.5)}, "attitude of length 0.707, allowed: 1"),
        ({"position": (0.0, 200.0, 0.0)}, "position 200 m from the origin, allowed: 100 m"),
        ({"nu": (0.0, 30.0, 40.0, 0.0, 0.0, 0.0)}, "speed 50 m/s, allowed: 20 m/s"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else None,
)
def test_a_state_that_can_be_none_is_refused_with_its_reason(change, words):
    assert checked_state(GOOD._replace(**change), position_max_m=100.0, speed_max_mps=20.0) == (None, words)


def test_a_good_state_stays_the_same_object():
    assert checked_state(GOOD)[0] is GOOD


def test_an_attitude_that_is_almost_of_length_1_is_made_so():
    state, words = checked_state(GOOD._replace(attitude=(0.704, 0.0, 0.0, 0.704)))
    assert words == ""
    assert state is not None
    assert state.attitude == pytest.approx((math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)))


@given(st.tuples(*[ANYTHING] * 3), st.tuples(*[ANYTHING] * 4), st.tuples(*[ANYTHING] * 6), ANYTHING)
def test_what_passes_is_finite_and_has_an_attitude(position, attitude, nu, sd_m):
    state, words = checked_state(VehicleState(0, position, attitude, nu, position_sd_m=sd_m))
    assert (state is None) == bool(words)
    if state is not None:
        assert all(map(math.isfinite, (*state.position, *state.nu, state.position_sd_m)))
        assert math.hypot(*state.attitude) == pytest.approx(1.0, abs=1e-6)
