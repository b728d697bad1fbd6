"""Claims about the controller of kinematic vehicles."""

import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.controllers import VelocityReference
from auv_control.controllers.velocity_direct import Controller, Params
from auv_core.geometry import heading_from_quaternion, quaternion_from_heading
from auv_core.messages import VehicleState
from auv_core.models.kinematic import Model
from auv_core.models.kinematic import Params as Hull

ANGLES = st.floats(-math.pi, math.pi)


def _at(heading_rad):
    return VehicleState(0, (0.0, 0.0, 0.0), quaternion_from_heading(heading_rad), (0.0,) * 6)


def test_the_velocity_is_handed_on_as_it_is():
    command = Controller(Params(), 0.1).step(_at(0.3), VelocityReference((0.1, -0.2, 0.3), 0.3))
    assert command.velocity == (0.1, -0.2, 0.3)
    assert command.yaw_rate_radps == pytest.approx(0.0, abs=1e-12)


@settings(max_examples=60, deadline=None)
@given(ANGLES, ANGLES)
def test_the_vehicle_turns_the_short_way_and_no_further_than_the_error(now_rad, wanted_rad):
    command = Controller(Params(heading_gain_ps=2.0), 0.1).step(
        _at(now_rad), VelocityReference((0.0,) * 3, wanted_rad)
    )
    error_rad = command.yaw_rate_radps / 2.0
    assert abs(error_rad) <= math.pi + 1e-9
    assert math.remainder(now_rad + error_rad - wanted_rad, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


@settings(max_examples=20, deadline=None)
@given(ANGLES, ANGLES)
def test_the_heading_settles_on_the_one_asked(start_rad, wanted_rad):
    model, controller = Model(Hull()), Controller(Params(), 0.1)
    state: Any = model.initial_state((0.0, 0.0, 0.0), start_rad)
    for tick in range(200):
        nav = VehicleState(tick, state[:3], state[3:7], state[7:])
        command = controller.step(nav, VelocityReference((0.1, 0.0, 0.0), wanted_rad))
        state = model.step(state, (*command.velocity, 0.0, 0.0, command.yaw_rate_radps), (0.0,) * 3, 0.1)
    error_rad = heading_from_quaternion(state[3:7]) - wanted_rad
    assert math.remainder(error_rad, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-6)
