"""Claims about the circular path."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.references.circle import Params, Reference

MODERATE = settings(max_examples=60, deadline=None)
CIRCLES = st.builds(
    Params,
    radius_m=st.floats(0.5, 100.0),
    rate_radps=st.floats(-0.5, 0.5),
    depth_m=st.floats(0.0, 100.0),
    heading_rad=st.floats(-3.0, 3.0),
)
TIMES_S = st.floats(0.0, 1000.0)


@MODERATE
@given(CIRCLES, TIMES_S)
def test_velocity_is_the_derivative_of_position(params, t_s):
    path, step_s = Reference(params), 1e-3
    difference = (np.array(path.position(t_s + step_s)) - path.position(t_s - step_s)) / (2.0 * step_s)
    np.testing.assert_allclose(path.velocity(t_s), difference, atol=1e-5)


@MODERATE
@given(CIRCLES, TIMES_S)
def test_the_path_stays_on_the_circle_at_its_depth(params, t_s):
    north, east, down = Reference(params).position(t_s)
    assert math.hypot(north, east) == pytest.approx(params.radius_m)
    assert down == params.depth_m


@MODERATE
@given(CIRCLES, TIMES_S)
def test_the_path_repeats_after_its_period(params, t_s):
    path = Reference(params)
    if abs(params.rate_radps) < 1e-3:
        return
    np.testing.assert_allclose(path.position(t_s + path.period_s), path.position(t_s), atol=1e-6)


def test_the_default_is_the_path_of_the_thesis():
    """Eq. (5.44): eta_d = (10 sin 0.01 t, 10 cos 0.01 t, 10), psi_d = pi / 3."""
    path = Reference(Params())
    t_s = 123.0
    assert path.position(t_s) == pytest.approx((10.0 * math.sin(1.23), 10.0 * math.cos(1.23), 10.0))
    assert path.position(0.0) == (0.0, 10.0, 10.0)
    assert path.velocity(0.0) == pytest.approx((0.1, 0.0, 0.0))
    assert path.heading_rad == pytest.approx(math.pi / 3.0)


def test_a_path_that_does_not_turn_has_no_period():
    assert Reference(Params(rate_radps=0.0)).period_s is None
