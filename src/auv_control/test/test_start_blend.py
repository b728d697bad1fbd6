"""Claims about the blended start and the wrapped angle."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.start_blend import blend, wrapped

MODERATE = settings(max_examples=100, deadline=None)


def test_the_offset_goes_from_all_to_nothing():
    assert blend(0.0, 40.0) == blend(-1.0, 40.0) == (1.0, 0.0, 0.0)
    assert blend(40.0, 40.0) == blend(1e6, 40.0) == blend(0.0, 0.0) == (0.0, 0.0, 0.0)
    assert blend(20.0, 40.0)[0] == pytest.approx(0.5)


@MODERATE
@given(st.floats(0.0, 1.0), st.floats(1.0, 100.0))
def test_rates_are_the_derivatives(share, duration_s):
    t_s, step_s = share * duration_s, 1e-4 * duration_s
    before, now, after = (blend(t_s + k * step_s, duration_s) for k in (-1, 0, 1))
    assert (after[0] - before[0]) / (2.0 * step_s) == pytest.approx(now[1], abs=1e-5 / duration_s)
    assert (after[1] - before[1]) / (2.0 * step_s) == pytest.approx(now[2], abs=1e-2 / duration_s**2)


@MODERATE
@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_it_never_rises(one, other):
    early, late = sorted((one, other))
    assert blend(late, 1.0)[0] <= blend(early, 1.0)[0] + 1e-12


@MODERATE
@given(st.floats(-50.0, 50.0))
def test_a_wrapped_angle_is_the_same_direction(angle_rad):
    turned = wrapped(angle_rad)
    assert -math.pi < turned <= math.pi
    assert math.cos(turned) == pytest.approx(math.cos(angle_rad), abs=1e-9)
    assert math.sin(turned) == pytest.approx(math.sin(angle_rad), abs=1e-9)


def test_half_a_turn_is_positive():
    assert wrapped(math.pi) == wrapped(-math.pi) == math.pi
