"""Claims about the fuzzy separation."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from auv_core.params import ConfigError, load
from auv_flocking.mamdani import infer
from auv_flocking.separation.fuzzy import Params, Separation

MODERATE = settings(max_examples=80, deadline=None)
OFFSETS = st.tuples(*[st.floats(-6.0, 6.0)] * 3).filter(lambda v: math.hypot(*v) > 0.05)
SPACINGS_M = st.floats(0.5, 4.0)
ORIGIN = (0.0, 0.0, 0.0)
LAW = Separation(Params())
PRINTED = Separation(Params(obstacles="printed"))


@MODERATE
@given(OFFSETS, SPACINGS_M)
def test_it_pushes_along_the_pair_with_the_inferred_force(own, spacing_m):
    distance_m = math.hypot(*own)
    force = infer(distance_m - spacing_m, Params().input_peaks_m, Params().output_peaks_mps)
    expected = -force * np.array(own) / distance_m
    np.testing.assert_allclose(LAW.velocity(own, ORIGIN, spacing_m), expected, atol=8e-4)


@MODERATE
@given(OFFSETS, OFFSETS, SPACINGS_M, st.floats(0.1, 5.0))
def test_it_is_antisymmetric_and_scales_with_its_gain(a, b, spacing_m, gain):
    assume(math.dist(a, b) > 1e-6)
    law = Separation(Params(gain=gain))
    there, back = law.velocity(a, b, spacing_m), law.velocity(b, a, spacing_m)
    np.testing.assert_allclose(there, np.negative(back), atol=1e-12)
    np.testing.assert_allclose(there, gain * np.array(LAW.velocity(a, b, spacing_m)), rtol=1e-9)


def test_it_repels_inside_the_spacing_attracts_outside_and_never_more_than_the_outer_set():
    for distance_m in np.linspace(0.01, 12.0, 400).tolist():
        (push, _, _) = LAW.velocity((distance_m, 0.0, 0.0), ORIGIN, 2.0)
        assert push * (2.0 - distance_m) >= 0.0
        assert abs(push) <= 5.0 / 3.0 + 1e-12


def test_the_spacing_of_a_flock_is_where_force_and_attraction_balance():
    """A tetrahedron of edge r: K r = n f(r - d) with K = 1.8 and n = 4 has the root 1.959 m (Table 6.1)."""
    edges_m = np.linspace(1.9, 2.0, 2001)
    rest = [1.8 * r + 4.0 * -LAW.velocity((r, 0.0, 0.0), ORIGIN, 2.0)[0] for r in edges_m.tolist()]
    assert np.interp(0.0, rest, edges_m) == pytest.approx(1.9590, abs=3e-4)


def test_with_even_peaks_the_flock_would_collapse():
    """The balance of before with sets of 2.5 m is at 0.96 m: narrow sets are what makes the law work."""
    even = Separation(Params(input_peaks_m=(-5.0, -2.5, 0.0, 2.5, 5.0)))
    edges_m = np.linspace(0.1, 2.0, 2001)
    rest = [1.8 * r + 4.0 * -even.velocity((r, 0.0, 0.0), ORIGIN, 2.0)[0] for r in edges_m.tolist()]
    assert np.interp(0.0, rest, edges_m) == pytest.approx(0.96, abs=0.01)


@MODERATE
@given(OFFSETS, SPACINGS_M)
def test_an_obstacle_only_repels_unless_the_printed_form_is_asked_for(own, spacing_m):
    distance_m = math.hypot(*own)
    away = np.dot(LAW.obstacle_velocity(own, ORIGIN, spacing_m), own)
    assert away >= 0.0
    if distance_m >= spacing_m:
        assert away == 0.0
    else:
        assert LAW.obstacle_velocity(own, ORIGIN, spacing_m) == LAW.velocity(own, ORIGIN, spacing_m)
    assert PRINTED.obstacle_velocity(own, ORIGIN, spacing_m) == LAW.velocity(own, ORIGIN, spacing_m)


def test_the_printed_form_draws_the_flock_to_an_obstacle():
    assert PRINTED.obstacle_velocity((6.0, 0.0, 0.0), ORIGIN, 2.0)[0] < -1.0


@MODERATE
@given(OFFSETS, SPACINGS_M, st.sampled_from([LAW, PRINTED]))
def test_the_velocities_are_the_fall_of_the_potentials(own, spacing_m, law):
    assume(abs(math.hypot(*own) - spacing_m) > 1e-3)
    step_m = 1e-6
    for potential, velocity in (
        (law.potential, law.velocity),
        (law.obstacle_potential, law.obstacle_velocity),
    ):
        gradient = [
            (
                potential(math.hypot(*np.add(own, e)), spacing_m)
                - potential(math.hypot(*np.subtract(own, e)), spacing_m)
            )
            / (2.0 * step_m)
            for e in step_m * np.eye(3)
        ]
        np.testing.assert_allclose(velocity(own, ORIGIN, spacing_m), np.negative(gradient), atol=2e-4)


def test_the_potential_is_least_and_zero_at_the_spacing():
    assert LAW.potential(2.0, 2.0) == 0.0
    values = [LAW.potential(r, 2.0) for r in np.linspace(0.1, 9.0, 90).tolist()]
    assert min(values) >= 0.0


@pytest.mark.parametrize("distance_m", [0.0, 5e-324, 1e-200, 1e-12, 1e-6])
def test_vehicles_in_one_place_give_a_finite_answer(distance_m):
    assert np.isfinite(LAW.velocity((distance_m, 0.0, 0.0), ORIGIN, 2.0)).all()


@pytest.mark.parametrize("name", ["input_peaks_m", "output_peaks_mps"])
def test_sets_out_of_order_are_refused(name):
    with pytest.raises(ConfigError, match=rf"^x\.{name}: .* is not allowed; allowed: five ascending numbers"):
        load(Params, {name: [-2.0, 1.0, 0.0, 1.0, 2.0]}, "x")
