"""Claims about the circular path."""

import math
from dataclasses import replace

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
    heading=st.sampled_from(["fixed", "tangent"]),
)
TIMES_S = st.floats(0.0, 1000.0)


@MODERATE
@given(CIRCLES, TIMES_S)
def test_rates_are_the_derivatives_of_their_values(params, t_s):
    path, step_s = Reference(params), 1e-3
    before, now, after = path.at(t_s - step_s), path.at(t_s), path.at(t_s + step_s)
    for rate, of in (("velocity", "position"), ("acceleration", "velocity")):
        difference = np.subtract(getattr(after, of), getattr(before, of)) / (2.0 * step_s)
        np.testing.assert_allclose(getattr(now, rate), difference, atol=1e-5)
    turned_rad = math.remainder(after.heading_rad - before.heading_rad, 2.0 * math.pi)
    assert now.heading_rate_radps == pytest.approx(turned_rad / (2.0 * step_s), abs=1e-6)


@MODERATE
@given(CIRCLES, TIMES_S)
def test_a_tangent_heading_points_along_the_path(params, t_s):
    point = Reference(replace(params, heading="tangent")).at(t_s)
    speed_mps = math.hypot(*point.velocity)
    along = (speed_mps * math.cos(point.heading_rad), speed_mps * math.sin(point.heading_rad), 0.0)
    np.testing.assert_allclose(point.velocity, along, atol=1e-9)


@MODERATE
@given(CIRCLES, TIMES_S)
def test_the_path_stays_on_the_circle_at_its_depth(params, t_s):
    north, east, down = Reference(params).at(t_s).position
    assert math.hypot(north, east) == pytest.approx(params.radius_m)
    assert down == params.depth_m


@MODERATE
@given(CIRCLES, TIMES_S)
def test_the_path_repeats_after_its_period(params, t_s):
    path = Reference(params)
    if abs(params.rate_radps) < 1e-3:
        return
    np.testing.assert_allclose(path.at(t_s + path.period_s).position, path.at(t_s).position, atol=1e-6)


def test_the_default_is_the_path_of_the_thesis():
    """Eq. (5.44): eta_d = (10 sin 0.01 t, 10 cos 0.01 t, 10), psi_d = pi / 3."""
    path = Reference(Params())
    t_s = 123.0
    assert path.at(t_s).position == pytest.approx((10.0 * math.sin(1.23), 10.0 * math.cos(1.23), 10.0))
    assert path.at(0.0).position == (0.0, 10.0, 10.0)
    assert path.at(0.0).velocity == pytest.approx((0.1, 0.0, 0.0))
    assert path.at(t_s).heading_rad == pytest.approx(math.pi / 3.0)


def test_a_path_that_does_not_turn_has_no_period():
    assert Reference(Params(rate_radps=0.0)).period_s is None
