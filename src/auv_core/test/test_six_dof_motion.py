"""Claims about the motion of a vehicle over time: energy, currents, closed forms, any attitude."""

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

import auv_core.models
from auv_core.geometry import body_to_ned, ned_to_body, quaternion_from_heading
from auv_core.models._hull_forces import momentum
from auv_core.models.six_dof import Model, constants
from auv_core.params import load_section

PRESETS = sorted((Path(auv_core.models.__file__).parent / "presets").glob("*.yaml"))
STILL = (0.0, 0.0, 0.0)
NO_WRENCH = (0.0,) * 6


def _preset(name):
    (path,) = [path for path in PRESETS if path.stem == name]
    return load_section(yaml.safe_load(path.read_text()), name, "auv_core.models").params


ODIN = _preset("odin")
UNDAMPED = replace(ODIN, linear_damping=NO_WRENCH, quadratic_damping=NO_WRENCH)


def _fly(params, state, *, wrench=NO_WRENCH, current=STILL, dt_s=0.02, steps=500):
    model = Model(params)
    states = [state]
    for _ in range(steps):
        states.append(model.step(states[-1], wrench, current, dt_s))
    return np.array(states)


def _energy(params, state):
    """Return kinetic energy plus potential energy of weight and buoyancy (J)."""
    attitude, velocity, rates = tuple(state[3:7]), tuple(state[7:10]), tuple(state[10:13])
    linear, angular = momentum(velocity, rates, constants(params))
    down = ned_to_body(attitude, (0.0, 0.0, 1.0))
    potential = -(params.weight_n - params.buoyancy_n) * state[2] - params.cog_z_m * params.weight_n * down[2]
    return 0.5 * (np.dot(velocity, linear) + np.dot(rates, angular)) + potential


@pytest.mark.parametrize("path", PRESETS, ids=lambda path: path.stem)
def test_every_preset_loads_and_flies(path):
    section = load_section(yaml.safe_load(path.read_text()), path.stem, "auv_core.models")
    module = __import__(f"auv_core.models.{section.kind}", fromlist=["Model"])
    model = module.Model(section.params)
    state = model.initial_state((1.0, 2.0, 3.0), 0.5)
    for _ in range(10):
        state = model.step(
            state,
            model.limited_command((0.5, -0.2, 0.1, 0.0, 0.0, 0.3, 0.2, -0.1)[: len(model.resting_command())]),
            STILL,
            0.02,
        )
    assert np.isfinite(state).all()


@pytest.mark.parametrize("path", PRESETS, ids=lambda path: path.stem)
def test_every_preset_says_where_its_numbers_come_from(path):
    assert path.read_text().startswith("# ")


def test_odin_is_neutrally_buoyant():
    assert ODIN.weight_n == ODIN.buoyancy_n == pytest.approx(9.81 * ODIN.mass_kg)


@pytest.mark.parametrize("buoyancy_n", [ODIN.weight_n, ODIN.weight_n - 20.0])
def test_energy_is_conserved_without_damping_and_thrust(buoyancy_n):
    params = replace(UNDAMPED, added_mass=(60.0, 20.0, 90.0, 1.0, 4.0, 2.0), buoyancy_n=buoyancy_n)
    start = (0.0, 0.0, 5.0, *quaternion_from_heading(0.4), 0.8, -0.5, 0.3, 0.6, -0.4, 0.9)
    states = _fly(params, start, dt_s=0.005, steps=4000)
    energies = [_energy(params, state) for state in states[::100]]
    assert np.ptp(energies) < 1e-6 * (abs(energies[0]) + 1.0)
    assert np.abs(np.diff(states[:, 10:13], axis=0)).max() > 0.0, "the test must see the axes exchange energy"


@settings(max_examples=10, deadline=None)
@given(
    st.tuples(*[st.floats(-0.5, 0.5)] * 3),
    st.tuples(*[st.floats(-0.5, 0.5)] * 6),
    st.tuples(*[st.floats(-20.0, 20.0)] * 6),
)
def test_a_uniform_current_only_adds_its_drift(current, nu, wrench):
    attitude = quaternion_from_heading(0.7)
    carried = ned_to_body(attitude, current)
    moving = (*[a + b for a, b in zip(nu[:3], carried, strict=True)], *nu[3:])
    still = _fly(ODIN, (0.0, 0.0, 5.0, *attitude, *nu), wrench=wrench, steps=250)
    drifting = _fly(ODIN, (0.0, 0.0, 5.0, *attitude, *moving), wrench=wrench, current=current, steps=250)
    time_s = 0.02 * np.arange(251)[:, np.newaxis]
    np.testing.assert_allclose(drifting[:, :3] - time_s * current, still[:, :3], atol=1e-5)
    np.testing.assert_allclose(drifting[:, 3:7], still[:, 3:7], atol=1e-6)


def test_a_hull_without_thrust_ends_up_drifting_with_the_water():
    current = (0.3, -0.2, 0.1)
    params = replace(ODIN, linear_damping=(60.0,) * 3 + (20.0,) * 3)
    last = _fly(params, (0.0,) * 3 + quaternion_from_heading(1.0) + NO_WRENCH, current=current, steps=3000)[
        -1
    ]
    np.testing.assert_allclose(body_to_ned(tuple(last[3:7]), tuple(last[7:10])), current, atol=1e-4)


@pytest.mark.parametrize("linear", [0.0, 25.0])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_terminal_speed_is_that_of_the_force_balance(axis, linear):
    force_n = 30.0
    quadratic = ODIN.quadratic_damping[axis]
    params = replace(ODIN, linear_damping=(linear,) * 6)
    wrench = tuple(force_n if i == axis else 0.0 for i in range(6))
    last = _fly(params, (0.0,) * 3 + (1.0, 0.0, 0.0, 0.0) + NO_WRENCH, wrench=wrench, dt_s=0.05, steps=2400)[
        -1
    ]
    terminal_mps = (-linear + math.sqrt(linear**2 + 4.0 * quadratic * force_n)) / (2.0 * quadratic)
    # The start sets the hull swinging, and quadratic drag lets the last of that die out only as 1 / t.
    assert last[7 + axis] == pytest.approx(terminal_mps, rel=1e-4)


def test_surge_decays_as_the_closed_form_for_quadratic_drag():
    params = replace(ODIN, cog_z_m=0.0)
    start_mps, mass_kg = 1.5, params.mass_kg + params.added_mass[0]
    states = _fly(params, (0.0,) * 3 + (1.0, 0.0, 0.0, 0.0) + (start_mps,) + (0.0,) * 5, steps=1000)
    time_s = 0.02 * np.arange(1001)
    decay = 1.0 + params.quadratic_damping[0] * start_mps / mass_kg * time_s
    np.testing.assert_allclose(states[:, 7], start_mps / decay, rtol=1e-8)
    run_m = mass_kg / params.quadratic_damping[0] * np.log(decay)
    np.testing.assert_allclose(states[:, 0], run_m, rtol=1e-7, atol=1e-12)


def test_small_rolls_swing_at_the_frequency_of_the_pendulum():
    params = replace(UNDAMPED, mass_kg=125.0, added_mass=(0.0, 1e9, 0.0, 2.0, 2.0, 0.0))
    start = (0.0,) * 3 + (math.cos(5e-4), math.sin(5e-4), 0.0, 0.0) + NO_WRENCH
    roll = _fly(params, start, dt_s=0.01, steps=2000)[:, 4]
    crossings = np.flatnonzero(np.diff(np.sign(roll)))
    period_s = 2.0 * 0.01 * np.diff(crossings).mean()
    stiffness = params.cog_z_m * params.weight_n
    assert period_s == pytest.approx(2.0 * math.pi * math.sqrt((8.0 + 2.0) / stiffness), rel=5e-3)


@pytest.mark.parametrize(
    "moment", [(50.0, 0.0, 0.0), (0.0, 50.0, 0.0), (0.0, -90.0, 0.0), (30.0, 80.0, 10.0)]
)
def test_motion_through_ninety_degrees_and_upside_down_stays_finite_and_a_rotation(moment):
    weak = replace(ODIN, cog_z_m=0.01)
    states = _fly(
        weak, (0.0,) * 3 + (1.0, 0.0, 0.0, 0.0) + NO_WRENCH, wrench=(5.0, 0.0, 0.0, *moment), steps=1500
    )
    assert np.isfinite(states).all()
    np.testing.assert_allclose(np.linalg.norm(states[:, 3:7], axis=1), 1.0, atol=1e-14)
    down = [ned_to_body(tuple(q), (0.0, 0.0, 1.0))[2] for q in states[:, 3:7]]
    assert min(down) < -0.5, "the test must turn the hull over"


def test_a_hull_left_upside_down_comes_back_level():
    upside_down = (math.cos(1.55), math.sin(1.55), 0.0, 0.0)
    last = _fly(ODIN, (0.0,) * 3 + upside_down + NO_WRENCH, dt_s=0.05, steps=4000)[-1]
    assert ned_to_body(tuple(last[3:7]), (0.0, 0.0, 1.0))[2] > 0.99


def test_step_is_of_fourth_order():
    start = (0.0,) * 3 + quaternion_from_heading(0.3) + (0.5, 0.2, -0.1, 0.3, -0.2, 0.4)
    ends = [
        _fly(ODIN, start, wrench=(40.0, 10.0, -5.0, 3.0, 2.0, 5.0), dt_s=4.0 / steps, steps=steps)[-1]
        for steps in (20, 40, 80, 160)
    ]
    differences = [np.linalg.norm(a - b) for a, b in pairwise(ends)]
    assert np.log2(differences[0] / differences[1]) > 3.5
    assert np.log2(differences[1] / differences[2]) > 3.5
