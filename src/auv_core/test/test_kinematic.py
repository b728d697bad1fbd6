"""Claims about the single integrator."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_core.geometry import body_to_ned, heading_from_quaternion
from auv_core.models.kinematic import Model, Params

MODEL = Model(Params())
SPEED = st.floats(-3.0, 3.0)


@settings(max_examples=60, deadline=None)
@given(st.tuples(SPEED, SPEED, SPEED), SPEED, st.integers(1, 50))
def test_a_held_command_is_followed_exactly(velocity, yaw_rate, steps):
    state: Any = MODEL.initial_state((1.0, -2.0, 3.0), 0.5)
    for _ in range(steps):
        state = MODEL.step(state, (*velocity, 0.0, 0.0, yaw_rate), (0.0, 0.0, 0.0), 0.1)
    np.testing.assert_allclose(
        state[:3], np.array([1.0, -2.0, 3.0]) + 0.1 * steps * np.array(velocity), atol=1e-10
    )
    turned_rad = heading_from_quaternion(state[3:7]) - 0.5 - 0.1 * steps * yaw_rate
    assert math.remainder(turned_rad, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


@settings(max_examples=60, deadline=None)
@given(st.tuples(SPEED, SPEED, SPEED), SPEED)
def test_nu_is_the_commanded_velocity_in_the_body_frame(velocity, yaw_rate):
    state: Any = MODEL.step(
        MODEL.initial_state((0.0, 0.0, 0.0), 2.0), (*velocity, 0.0, 0.0, yaw_rate), (0.0,) * 3, 0.1
    )
    np.testing.assert_allclose(body_to_ned(state[3:7], state[7:10]), velocity, atol=1e-12)
    assert state[10:] == (0.0, 0.0, yaw_rate)


def test_one_long_step_is_as_good_as_many_short_ones():
    command = (0.3, -0.1, 0.2, 0.0, 0.0, 0.4)
    short = long = MODEL.initial_state((0.0, 0.0, 5.0), 0.0)
    for _ in range(10):
        short = MODEL.step(short, command, (0.0, 0.0, 0.0), 0.1)
    np.testing.assert_allclose(short[:7], MODEL.step(long, command, (0.0, 0.0, 0.0), 1.0)[:7], atol=1e-12)


def test_it_has_no_actuators_to_limit():
    assert MODEL.limited_command((9.0,) * 6) == (9.0,) * 6
