"""Claims about the potential-function separation."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from auv_flocking.separation.mathematical import Params, Separation

MODERATE = settings(max_examples=80, deadline=None)
OFFSETS = st.tuples(*[st.floats(-3.0, 3.0)] * 3).filter(lambda v: math.hypot(*v) > 0.2)
SPACINGS_M = st.floats(0.5, 4.0)


def _potential(own, other, spacing_m):
    """U(r) = log(r^2 / d) + d^2 / r^2, thesis Eq. (5.26)."""
    square = float(np.sum(np.square(np.subtract(own, other))))
    return math.log(square / spacing_m) + spacing_m**2 / square


@MODERATE
@given(OFFSETS, SPACINGS_M)
def test_inside_the_spacing_it_is_minus_the_gradient_of_the_potential(own, spacing_m):
    assume(math.hypot(*own) < spacing_m - 1e-3)
    other, step_m = (0.0, 0.0, 0.0), 1e-5
    gradient = [
        (_potential(np.add(own, e), other, spacing_m) - _potential(np.subtract(own, e), other, spacing_m))
        / (2 * step_m)
        for e in step_m * np.eye(3)
    ]
    np.testing.assert_allclose(
        Separation(Params()).velocity(own, other, spacing_m), -np.array(gradient), rtol=1e-4, atol=1e-4
    )


@MODERATE
@given(OFFSETS, SPACINGS_M)
def test_it_is_the_fall_of_its_own_potential_inside_and_outside(own, spacing_m):
    assume(abs(math.hypot(*own) - spacing_m) > 1e-3)
    law, other, step_m = Separation(Params(gain=1.5)), (0.0, 0.0, 0.0), 1e-6
    gradient = [
        (
            law.potential(math.hypot(*np.add(own, e)), spacing_m)
            - law.potential(math.hypot(*np.subtract(own, e)), spacing_m)
        )
        / (2.0 * step_m)
        for e in step_m * np.eye(3)
    ]
    np.testing.assert_allclose(
        law.velocity(own, other, spacing_m), np.negative(gradient), rtol=1e-4, atol=1e-4
    )


def test_the_potential_is_zero_from_the_spacing_on_and_endless_at_no_distance():
    law = Separation(Params())
    assert law.potential(2.0, 2.0) == law.potential(7.0, 2.0) == 0.0
    assert law.potential(1.0, 2.0) == pytest.approx(math.log(0.25) + 3.0)
    assert law.potential(0.0, 2.0) == math.inf


@MODERATE
@given(OFFSETS, SPACINGS_M)
def test_at_and_beyond_the_spacing_it_is_zero(own, spacing_m):
    assume(math.hypot(*own) >= spacing_m)
    assert Separation(Params()).velocity(own, (0.0, 0.0, 0.0), spacing_m) == (0.0, 0.0, 0.0)
    assert Separation(Params()).velocity((spacing_m, 0.0, 0.0), (0.0, 0.0, 0.0), spacing_m) == (0.0, 0.0, 0.0)


@MODERATE
@given(OFFSETS, SPACINGS_M)
def test_it_only_ever_pushes_apart(own, spacing_m):
    assert np.dot(Separation(Params()).velocity(own, (0.0, 0.0, 0.0), spacing_m), own) >= 0.0


@MODERATE
@given(OFFSETS, OFFSETS, SPACINGS_M, st.floats(0.1, 5.0))
def test_it_is_antisymmetric_and_scales_with_its_gain(a, b, spacing_m, gain):
    law = Separation(Params(gain=gain))
    there, back = law.velocity(a, b, spacing_m), law.velocity(b, a, spacing_m)
    assert there == tuple(-x for x in back)
    np.testing.assert_allclose(
        there, gain * np.array(Separation(Params()).velocity(a, b, spacing_m)), rtol=1e-12
    )


def test_a_value_worked_by_hand():
    """r = 1, d = 2: 2 (d^2 - r^2) / r^4 = 6 along the line from the other."""
    assert Separation(Params()).velocity((1.0, 2.0, 3.0), (2.0, 2.0, 3.0), 2.0) == (-6.0, 0.0, 0.0)


def test_the_spacing_of_a_flock_is_where_repulsion_and_attraction_balance():
    """K = 2 n (d^2 - r^2) / r^4 with n = 4, d = 2, K = 1.8 has the root r = 1.5950 m (spec, section 2)."""
    r_m = 1.5950
    (push, _, _) = Separation(Params()).velocity((r_m, 0.0, 0.0), (0.0, 0.0, 0.0), 2.0)
    assert 4.0 * push / r_m == pytest.approx(1.8, abs=2e-3)


@pytest.mark.parametrize("distance_m", [0.0, 5e-324, 1e-200, 1e-90, 1e-12, 1e-6])
def test_vehicles_in_one_place_give_a_finite_answer(distance_m):
    velocity = Separation(Params()).velocity((distance_m, 0.0, 0.0), (0.0, 0.0, 0.0), 2.0)
    assert np.isfinite(velocity).all()
