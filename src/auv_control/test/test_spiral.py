"""Claims about the spiral path."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.references import circle
from auv_control.references.spiral import Params, Reference

MODERATE = settings(max_examples=60, deadline=None)
SPIRALS = st.builds(
    Params,
    radius_m=st.floats(0.5, 50.0),
    rate_radps=st.floats(-0.5, 0.5),
    depth_m=st.floats(0.0, 50.0),
    depth_rate_mps=st.floats(-1.0, 1.0),
)
TIMES_S = st.floats(0.0, 500.0)


@MODERATE
@given(SPIRALS, TIMES_S)
def test_rates_are_the_derivatives(params, t_s):
    path, step_s = Reference(params), 1e-3
    before, now, after = (path.at(t_s + k * step_s) for k in (-1, 0, 1))
    for value, rate in (("position", "velocity"), ("velocity", "acceleration")):
        slope = np.subtract(getattr(after, value), getattr(before, value)) / (2.0 * step_s)
        np.testing.assert_allclose(getattr(now, rate), slope, atol=1e-5)


@MODERATE
@given(SPIRALS, TIMES_S)
def test_seen_from_above_it_is_the_circle(params, t_s):
    flat = circle.Params(radius_m=params.radius_m, rate_radps=params.rate_radps)
    np.testing.assert_allclose(
        Reference(params).at(t_s).position[:2], circle.Reference(flat).at(t_s).position[:2]
    )


def test_the_default_is_the_path_of_the_thesis():
    """Eq. (3.39): eta_d = (10 sin 0.01 t, 10 cos 0.01 t, t), psi_d = pi / 3."""
    point = Reference(Params()).at(123.0)
    assert point.position == pytest.approx((10.0 * math.sin(1.23), 10.0 * math.cos(1.23), 123.0))
    assert point.velocity == pytest.approx((0.1 * math.cos(1.23), -0.1 * math.sin(1.23), 1.0))
    assert (point.heading_rad, point.heading_rate_radps) == (math.pi / 3.0, 0.0)


def test_it_has_no_period():
    assert Reference(Params()).period_s is None
