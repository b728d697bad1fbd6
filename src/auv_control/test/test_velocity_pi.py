"""Claims about the inner loop, flown on the ODIN model at 10 Hz."""

import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import auv_core.models
from auv_control.controllers import VelocityReference
from auv_control.controllers.velocity_pi import Controller, Params
from auv_core.geometry import (
    body_to_ned,
    heading_from_quaternion,
    ned_to_body,
    quaternion_from_heading,
    quaternion_product,
)
from auv_core.messages import VehicleState
from auv_core.models.six_dof import Model
from auv_core.params import load_section

PERIOD_S, DT_S = 0.1, 0.02
CURRENT = (0.2, -0.15, 0.05)
_PRESET = Path(auv_core.models.__file__).parent / "presets" / "odin.yaml"
ODIN = load_section(yaml.safe_load(_PRESET.read_text()), "odin", "auv_core.models").params

UNIT = st.floats(-1.0, 1.0)
ATTITUDES = (
    st.tuples(UNIT, UNIT, UNIT, UNIT)
    .filter(lambda q: math.hypot(*q) > 1e-2)
    .map(lambda q: tuple(x / math.hypot(*q) for x in q))
)


def _fly(reference_at, duration_s, *, attitude=(1.0, 0.0, 0.0, 0.0), current=CURRENT, params=None):
    """Return the states (ticks + 1, 13), velocities over ground (ticks + 1, 3) and wrenches (ticks, 6)."""
    model, controller = Model(ODIN), Controller(params or Params(), PERIOD_S)
    states, wrenches = [(0.0, 0.0, 10.0, *attitude, *(0.0,) * 6)], []
    for tick in range(round(duration_s / PERIOD_S)):
        state = states[-1]
        nav = VehicleState(tick, state[:3], state[3:7], state[7:])
        wrenches.append(controller.step(nav, reference_at(tick * PERIOD_S)).tau)
        given = model.limited_command(wrenches[-1])
        for _ in range(round(PERIOD_S / DT_S)):
            state = model.step(state, given, current, DT_S)
        states.append(state)
    velocities = [body_to_ned(state[3:7], state[7:10]) for state in states]
    return np.array(states), np.array(velocities), np.array(wrenches)


def _always(velocity, heading_rad=0.0):
    return lambda _t_s: VelocityReference(velocity, heading_rad)


def test_a_step_in_velocity_settles_on_it_in_a_current():
    _, velocities, _ = _fly(_always((0.2, 0.1, -0.1)), 60.0)
    np.testing.assert_allclose(velocities[300:], np.broadcast_to((0.2, 0.1, -0.1), (301, 3)), atol=2e-3)
    np.testing.assert_allclose(velocities[-1], (0.2, 0.1, -0.1), atol=1e-5)


def test_a_step_in_velocity_is_mostly_made_within_two_seconds_and_overshoots_little():
    _, velocities, _ = _fly(_always((0.2, 0.0, 0.0)), 30.0, current=(0.0, 0.0, 0.0))
    north = velocities[:, 0]
    assert north[20] > 0.8 * 0.2
    assert north.max() < 1.25 * 0.2


def test_the_bandwidth_is_gain_over_mass():
    """Without integral the loop is of first order: after m / K_p the error is 1 / e (drag aside)."""
    params = Params(integral_gain_npm=0.0)
    _, velocities, _ = _fly(_always((0.05, 0.0, 0.0)), 2.0, current=(0.0, 0.0, 0.0), params=params)
    mass_kg = ODIN.mass_kg + ODIN.added_mass[0]
    tick = round(mass_kg / params.velocity_gain_nspm / PERIOD_S)
    assert 1.0 - velocities[tick, 0] / 0.05 == pytest.approx(
        math.exp(-tick * PERIOD_S * 300.0 / mass_kg), abs=0.06
    )


def test_station_is_held_against_the_current():
    states, velocities, _ = _fly(_always((0.0, 0.0, 0.0)), 60.0)
    assert np.linalg.norm(velocities[-1]) < 1e-4
    assert np.linalg.norm(states[-1, :3] - states[400, :3]) < 1e-2


def test_the_integral_does_not_wind_up_while_the_actuators_are_at_their_limit():
    def impossible_then_rest(t_s):
        return VelocityReference((5.0, 0.0, 0.0) if t_s < 60.0 else (0.0, 0.0, 0.0), 0.0)

    _, long_wait, _ = _fly(impossible_then_rest, 90.0)
    _, no_wait, _ = _fly(lambda t_s: impossible_then_rest(t_s + 55.0), 35.0)
    assert long_wait[600, 0] > 1.5, "the test must hold the actuators at their limit"
    brake = long_wait[600:, 0]
    assert brake.min() > -0.25
    assert np.flatnonzero(brake < 0.1)[0] * PERIOD_S < 8.0
    np.testing.assert_allclose(brake[80:], no_wait[50 + 80 :, 0], atol=0.05)


@settings(max_examples=60, deadline=None)
@given(
    ATTITUDES,
    st.tuples(*[st.floats(-5.0, 5.0)] * 6),
    st.tuples(*[st.floats(-1e3, 1e3)] * 3),
    st.floats(-4.0, 4.0),
)
def test_limits_are_held_whatever_is_asked(attitude, nu, velocity, heading_rad):
    params = Params()
    controller = Controller(params, PERIOD_S)
    for tick in range(5):
        tau = controller.step(
            VehicleState(tick, (0.0,) * 3, attitude, nu), VelocityReference(velocity, heading_rad)
        ).tau
        assert np.isfinite(tau).all()
        assert max(map(abs, tau[:3])) <= params.max_force_n
        assert max(map(abs, tau[3:])) <= params.max_moment_nm


@settings(max_examples=60, deadline=None)
@given(ATTITUDES, st.floats(-4.0, 4.0))
def test_both_quaternions_of_an_attitude_give_the_same_wrench(attitude, heading_rad):
    """So the hull turns the short way to its heading, never the long way round."""
    turn = quaternion_product(
        tuple(-x if i else x for i, x in enumerate(attitude)), quaternion_from_heading(heading_rad)
    )
    assume(abs(turn[0]) > 1e-9)  # at half a turn both ways are as short
    other = tuple(-x for x in attitude)
    first, second = (
        Controller(Params(), PERIOD_S)
        .step(VehicleState(0, (0.0,) * 3, q, (0.1,) * 6), VelocityReference((0.2, 0.0, 0.0), heading_rad))
        .tau
        for q in (attitude, other)
    )
    np.testing.assert_allclose(first, second, atol=1e-9)


def test_the_limits_that_it_believes_in_are_those_of_the_vehicle():
    params = Params()
    assert ODIN.max_wrench == (params.max_force_n,) * 3 + (params.max_moment_nm,) * 3


@settings(max_examples=10, deadline=None)
@given(ATTITUDES, st.floats(-3.0, 3.0))
def test_from_every_attitude_the_hull_comes_level_and_to_its_heading(attitude, heading_rad):
    states, _, _ = _fly(_always((0.0, 0.0, 0.0), heading_rad), 40.0, attitude=attitude)
    last = tuple(states[-1, 3:7])
    assert ned_to_body(last, (0.0, 0.0, 1.0))[2] > 0.9999
    assert math.remainder(heading_from_quaternion(last) - heading_rad, 2.0 * math.pi) == pytest.approx(
        0.0, abs=0.01
    )


def test_heading_is_held_while_the_velocity_turns():
    def round_and_round(t_s):
        return VelocityReference((0.2 * math.cos(0.1 * t_s), 0.2 * math.sin(0.1 * t_s), 0.0), 1.0)

    states, velocities, _ = _fly(round_and_round, 60.0, attitude=quaternion_from_heading(1.0))
    headings = np.array([heading_from_quaternion(tuple(q)) for q in states[:, 3:7]])
    assert np.abs(headings - 1.0).max() < 0.05
    wanted = np.array([round_and_round(PERIOD_S * tick).velocity for tick in range(len(velocities))])
    assert np.linalg.norm(velocities - wanted, axis=1)[200:].max() < 0.03


def test_the_hull_stays_level_while_it_speeds_up_as_a_flock_does():
    states, _, _ = _fly(lambda t_s: VelocityReference((0.2 * (int(t_s / 5.0) % 2), 0.0, 0.0), 0.0), 40.0)
    down = np.array([ned_to_body(tuple(q), (0.0, 0.0, 1.0))[2] for q in states[:, 3:7]])
    assert math.degrees(math.acos(down.min())) < 6.0


def test_two_controllers_with_the_same_calls_agree_to_the_last_bit():
    first, second = (_fly(_always((0.1, 0.2, 0.0)), 10.0)[2] for _ in range(2))
    np.testing.assert_array_equal(first, second)
