"""Claims about the autopilots of heading, depth and speed."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.guidance.autopilots import (
    AutopilotState,
    Measured,
    Params,
    Setpoint,
    initial_state,
    measured,
    piloted,
    step_autopilots,
)
from auv_control.guidance.depth import DepthState, dived, pitch_limit
from auv_control.guidance.speed import Params as Speed
from auv_control.guidance.speed import propelled
from auv_core.compiled import _compiled
from auv_core.geometry import quaternion_from_heading, quaternion_product, smallest_angle
from auv_core.messages import VehicleState
from auv_core.params import ConfigError, load

MODERATE = settings(max_examples=60, deadline=None)
PERIOD_S = 0.1
GAINS = Params().gains
CRUISE = Measured(0.0, 0.0, 0.0, 0.0, 30.0, 1.5, 1.5)
AHEAD = Setpoint(0.0, 0.0, 30.0, 1.5)
START = initial_state(30.0)


def _some(*bounds):
    return st.tuples(*[st.floats(-bound, bound) for bound in bounds])


MEASURED = _some(20.0, 1.5, 1.0, 1.0, 100.0, 3.0, 3.0).map(
    lambda row: Measured(*row)._replace(speed_mps=abs(row[5]))
)
SETPOINTS = _some(20.0, 0.1, 100.0, 2.5).map(lambda row: Setpoint(*row))
STATES = _some(1.0, 100.0, 100.0, 1.0, 20.0).map(
    lambda row: AutopilotState(row[0], DepthState(*row[1:4]), row[4])
)


def _piloted(now, setpoint, state=START):
    return piloted(now, setpoint, state, PERIOD_S, GAINS)


@MODERATE
@given(MEASURED, SETPOINTS, STATES)
def test_commands_stay_within_the_limits_of_the_actuators(now, setpoint, state):
    fins, after = _piloted(now, setpoint, state)
    assert abs(fins.rudder_rad) <= math.radians(15.0)
    assert abs(fins.stern_plane_rad) <= math.radians(15.0)
    assert 480.0 <= fins.propeller_rpm <= 1525.0
    assert abs(after.depth.depth_command_m - state.depth.depth_command_m) <= 0.04 + 1e-12


@MODERATE
@given(MEASURED, SETPOINTS, STATES, st.integers(-3, 3))
def test_whole_turns_of_the_heading_change_nothing(now, setpoint, state, turns):
    turned = setpoint._replace(heading_rad=setpoint.heading_rad + turns * math.tau)
    assert (
        _piloted(now, turned, state)[0].rudder_rad
        == pytest.approx(_piloted(now, setpoint, state)[0].rudder_rad, abs=1e-6)
        or abs(abs(smallest_angle(setpoint.heading_rad - now.heading_rad)) - math.pi) < 1e-6
    )


@MODERATE
@given(MEASURED, SETPOINTS, STATES)
def test_the_mirrored_heading_gives_the_mirrored_rudder(now, setpoint, state):
    mirrored, _ = _piloted(
        now._replace(heading_rad=-now.heading_rad, yaw_rate_radps=-now.yaw_rate_radps),
        setpoint._replace(heading_rad=-setpoint.heading_rad, turn_rate_radps=-setpoint.turn_rate_radps),
        state._replace(heading_integral_rads=-state.heading_integral_rads),
    )
    error = smallest_angle(setpoint.heading_rad - now.heading_rad)
    if abs(abs(error) - math.pi) > 1e-6:
        assert mirrored.rudder_rad == pytest.approx(-_piloted(now, setpoint, state)[0].rudder_rad, abs=1e-9)


def test_on_its_setpoint_a_vehicle_needs_no_fins_and_the_propeller_of_its_speed():
    fins, after = _piloted(CRUISE, AHEAD)
    assert fins == (0.0, 0.0, 895.5)
    assert after == START


def test_a_heading_to_starboard_takes_positive_rudder_and_a_greater_depth_a_positive_plane():
    fins, _ = _piloted(CRUISE, AHEAD._replace(heading_rad=0.1, depth_m=40.0))
    assert fins.rudder_rad == pytest.approx(0.15)
    assert fins.stern_plane_rad > 0.0


def test_the_pitch_command_is_limited_by_what_the_planes_hold():
    assert pitch_limit(1.0, GAINS.depth) == pytest.approx(0.85 * 0.164)
    assert pitch_limit(2.5, GAINS.depth) == math.radians(20.0)
    deep = dived(30.0, 80.0, 0.0, 0.0, 1.0, DepthState(50.0, 0.0, 0.0), PERIOD_S, GAINS.depth)
    assert deep.pitch_command_rad == -0.85 * 0.164
    assert deep.state.depth_integral_ms == 0.0, "held while the pitch command is clipped"


@pytest.mark.parametrize(("speed_mps", "rate_mps"), [(1.0, 0.0973), (1.5, 0.3240), (2.5, 0.4)])
def test_the_depth_command_moves_no_faster_than_the_vehicle_dives(speed_mps, rate_mps):
    _, after = _piloted(CRUISE._replace(speed_mps=speed_mps), AHEAD._replace(depth_m=40.0))
    assert (after.depth.depth_command_m - 30.0) / PERIOD_S == pytest.approx(rate_mps, abs=5e-5)


def test_the_speed_integral_is_held_at_the_floor_and_leaves_it():
    gains = Speed().gains
    assert propelled(1.8, 1.0, 0.0, PERIOD_S, gains) == (480.0, 0.0)
    assert propelled(0.5, 1.0, -30.0, PERIOD_S, gains) == (480.0, -30.0 + 0.5 * PERIOD_S)


def test_measurements_come_from_the_navigation():
    pitched = quaternion_product(quaternion_from_heading(1.0), (math.cos(0.1), 0.0, math.sin(0.1), 0.0))
    nav = VehicleState(0, (1.0, 2.0, 30.0), pitched, (1.5, 0.0, 0.2, 0.0, 0.01, 0.02))
    now = measured(nav.numbers, 1.4)
    assert now == pytest.approx((1.0, 0.2, 0.02, 0.01, 30.0, math.hypot(1.5, 0.2), 1.4))


def test_a_floor_above_the_limit_is_refused():
    with pytest.raises(ConfigError, match=r"least_rpm: 2000.0 is not allowed; allowed: at most largest_rpm"):
        load(Params, {"speed": {"least_rpm": 2000.0}}, "autopilots")


@MODERATE
@given(_some(*3 * [100.0], *4 * [1.0], *6 * [2.0]), SETPOINTS, STATES)
def test_the_step_is_the_autopilots_on_the_navigation_and_so_is_its_compiled_twin(row, setpoint, memory):
    norm = math.hypot(*row[3:7]) or 1.0
    state = (*row[:3], *(number / norm for number in row[3:7]), *row[7:])
    given_numbers = state, 1.3, tuple(setpoint), memory.numbers, PERIOD_S, GAINS.numbers
    fins, after = _piloted(measured(state, 1.3), setpoint, memory)
    assert step_autopilots(*given_numbers) == (*fins, *after.numbers)
    assert _compiled(step_autopilots)(*given_numbers) == (*fins, *after.numbers)
