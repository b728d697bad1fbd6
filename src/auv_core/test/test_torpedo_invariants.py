"""Claims about every torpedo: energy, current, attitude, actuators, and the compiled twin."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from torpedo_flights import STILL, lauv, preset, remus

from auv_core import compiled
from auv_core.geometry import body_to_ned, ned_to_body
from auv_core.models import make_model, torpedo, torpedo_coefficients
from auv_core.models._slender_hull import hull_force
from auv_core.models.torpedo_coefficients import water_force

MODELS = [remus(), remus(munk=True), remus(lift_in_both_planes=True), lauv()]
MODERATE = settings(max_examples=60, deadline=None)
SPEEDS, RATES = st.floats(-3.0, 3.0), st.floats(-1.0, 1.0)
CURRENTS = st.tuples(*[st.floats(-1.0, 1.0)] * 3)
COMMANDS = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-2000.0, 2000.0))
models = pytest.mark.parametrize("model", MODELS, ids=["strips", "munk", "sway lift", "coefficients"])


@st.composite
def states(draw, *, level=False):
    numbers = np.array([draw(st.floats(0.01, 1.0)), *(draw(st.floats(-1.0, 1.0)) for _ in range(3))])
    attitude = (1.0, 0.0, 0.0, 0.0) if level else tuple((numbers / np.linalg.norm(numbers)).tolist())
    nu = (draw(SPEEDS), draw(SPEEDS), draw(SPEEDS), draw(RATES), draw(RATES), draw(RATES))
    fins = (0.0, 0.0, 0.0) if level else (draw(st.floats(-0.3, 0.3)), draw(st.floats(-0.3, 0.3)), 900.0)
    return (1.0, -2.0, 30.0, *attitude, *nu, *fins)


def power(model, state):
    """Return the rate of the kinetic energy (W) in still water, without a command."""
    nu = np.array(state[7:13])
    rate = np.array(model.derivative(state, (0.0, 0.0, 0.0), STILL)[7:13])
    return 0.5 * (model.kinetic_energy(tuple(nu + rate)) - model.kinetic_energy(tuple(nu - rate)))


@pytest.mark.parametrize("munk", [False, True])
@MODERATE
@given(state=states(level=True))
def test_only_the_water_takes_energy_from_a_level_hull(munk, state):
    """So neither the Coriolis force nor the current's rotation does work."""
    model = remus(munk=munk)
    force, moment = hull_force(state[7:10], state[10:13], torpedo.water_of(model.params))
    given_w = np.dot(state[7:10], force) + np.dot(state[10:13], moment)
    assert given_w <= 1e-9
    assert power(model, state) == pytest.approx(given_w, rel=1e-9, abs=1e-6)


@MODERATE
@given(state=states(level=True))
def test_coriolis_forces_of_the_coefficients_do_no_work(state):
    model: Any = make_model(replace(preset("lauv"), params=replace(preset("lauv").params, net_weight_n=0.0)))
    coefficients = torpedo_coefficients._coefficients(torpedo_coefficients.numbers_of(model.params))
    force, moment = water_force(state[7:10], state[10:13], coefficients)
    given_w = np.dot(state[7:10], force) + np.dot(state[10:13], moment)
    assert power(model, state) == pytest.approx(given_w, rel=1e-9, abs=1e-6)


@models
@MODERATE
@given(state=states(), ahead_mps=st.floats(0.1, 3.0), command=COMMANDS, current=CURRENTS)
def test_a_current_carries_the_hull_along(model, state, ahead_mps, command, current):
    """
    Galilean invariance: seen from the water, the hull moves as in still water.

    It runs ahead: without motion along its axis and across there is no angle of attack.
    """
    state = (*state[:7], ahead_mps, *state[8:])
    in_body = ned_to_body(state[3:7], current)
    carried = (*state[:7], *(a + b for a, b in zip(state[7:10], in_body, strict=True)), *state[10:])
    still, moving = model.derivative(state, command, STILL), model.derivative(carried, command, current)
    assert moving[:3] == pytest.approx([a + b for a, b in zip(still[:3], current, strict=True)], abs=1e-9)
    turning = -np.cross(state[10:13], in_body)
    assert moving[7:10] == pytest.approx(np.array(still[7:10]) + turning, abs=1e-8)
    assert moving[3:7] == pytest.approx(still[3:7], abs=1e-9)
    assert moving[10:] == pytest.approx(still[10:], abs=1e-7)


def test_a_flight_in_a_current_is_that_in_still_water_carried_along():
    current, model = (0.3, -0.2, 0.1), remus()
    start = model.initial_state((0.0, 0.0, 30.0), 0.4, 1.5)
    carried = (*start[:7], *np.add(start[7:10], ned_to_body(start[3:7], current)).tolist(), *start[10:])
    command = (0.1, -0.05, 1000.0)
    still, moving = (
        model.step(start, command, STILL, 0.02, 1500),
        model.step(carried, command, current, 0.02, 1500),
    )
    assert np.subtract(moving[:3], still[:3]) == pytest.approx(np.multiply(30.0, current), abs=1e-4)
    over_ground = np.subtract(body_to_ned(moving[3:7], moving[7:10]), body_to_ned(still[3:7], still[7:10]))
    assert over_ground == pytest.approx(current, abs=1e-5)


@MODERATE
@given(state=states(), command=COMMANDS)
def test_the_propeller_by_ground_is_that_by_water_without_a_current(state, command):
    section = preset("remus100")
    propeller = replace(section.params.propeller, advance_by="ground")
    by_ground: Any = make_model(replace(section, params=replace(section.params, propeller=propeller)))
    assert by_ground.derivative(state, command, STILL) == remus().derivative(state, command, STILL)
    level = (*state[:3], 1.0, 0.0, 0.0, 0.0, 1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 900.0)
    with_it = (0.5, 0.0, 0.0)
    assert by_ground.derivative(level, command, with_it) != remus().derivative(level, command, with_it)


@models
@settings(max_examples=15, deadline=None)
@given(state=states(), command=COMMANDS, current=CURRENTS)
def test_motion_stays_finite_and_attitude_stays_a_rotation(model, state, command, current):
    for _ in range(5):
        state = model.step(state, model.limited_command(command), current, 0.05, 20)
        assert np.isfinite(state).all()
        assert math.hypot(*state[3:7]) == pytest.approx(1.0, abs=1e-12)


@models
@settings(max_examples=15, deadline=None)
@given(rudder=st.floats(0.02, 0.26), rpm=st.floats(500.0, 1500.0))
def test_port_is_the_mirror_image_of_starboard_without_the_propellers_torque(model, rudder, rpm):
    if model is not lauv():
        section = preset("remus100")
        propeller = replace(section.params.propeller, roll_ratio=0.0)
        model = make_model(replace(section, params=replace(model.params, propeller=propeller)))
    start = model.initial_state((0.0, 0.0, 10.0), 0.0, 1.0)
    starboard = model.step(start, (rudder, 0.0, rpm), STILL, 0.05, 100)
    port = model.step(start, (-rudder, 0.0, rpm), STILL, 0.05, 100)
    assert starboard[12] > 0.0
    assert port[12] == pytest.approx(-starboard[12], abs=1e-9)
    assert port[:3] == pytest.approx((starboard[0], -starboard[1], starboard[2]), abs=1e-9)


@models
def test_a_positive_stern_plane_lowers_the_nose(model):
    start = model.initial_state((0.0, 0.0, 10.0), 0.0, 1.2)
    diving, level, rising = (model.step(start, (0.0, s, 900.0), STILL, 0.05, 100) for s in (0.1, 0.0, -0.1))
    assert diving[2] > level[2] > rising[2]


@pytest.mark.parametrize("kind", [torpedo, torpedo_coefficients], ids=["strips", "coefficients"])
def test_compiled_and_plain_give_the_same_numbers_to_the_last_bit(kind):
    model = remus() if kind is torpedo else lauv()
    twin = compiled._compiled(kind.advance)
    start = model.initial_state((1.0, -2.0, 30.0), 0.3, 1.2)
    for command in ((0.25, -0.1, 1400.0), (-0.1, 0.2, -300.0), (0.0, 0.0, 0.0)):
        arguments = (start, command, (0.2, -0.1, 0.05), model.numbers, 0.05, 100)
        assert twin(*arguments) == kind.advance(*arguments)
