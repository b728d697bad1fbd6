"""Claims about the level vehicle: momentum, energy, frames, drag, limits."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

import auv_core.models
from auv_core.models.four_dof import Model, Params
from auv_core.params import load

PRESETS = Path(auv_core.models.__file__).parent / "presets"
MODERATE = settings(max_examples=100, deadline=None)
POSITIVE, SPEEDS, FORCES = st.floats(1.0, 500.0), st.floats(-3.0, 3.0), st.floats(-500.0, 500.0)
FOUR_POSITIVE = st.tuples(POSITIVE, POSITIVE, POSITIVE, POSITIVE)
PLANTS = st.builds(
    Params, inertia=FOUR_POSITIVE, linear_damping=FOUR_POSITIVE, quadratic_damping=FOUR_POSITIVE
)
NO_FORCE, STILL = (0.0,) * 6, (0.0, 0.0, 0.0)


@st.composite
def states(draw):
    heading = draw(st.floats(-math.pi, math.pi))
    u, v, w, r = (draw(SPEEDS) for _ in range(4))
    return (1.0, 2.0, 3.0, math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2), u, v, w, 0.0, 0.0, r)


def plant(name, **changes):
    raw = yaml.safe_load((PRESETS / f"{name}.yaml").read_text(encoding="utf-8"))
    return replace(load(Params, raw["params"], name), **changes)


def power(model, state, tau=NO_FORCE):
    """Return the rate of the kinetic energy (W)."""
    rate = model.derivative(state, tau, STILL)
    a, b, c, d = model.params.inertia
    u, v, w, r = state[7], state[8], state[9], state[12]
    return a * u * rate[7] + b * v * rate[8] + c * w * rate[9] + d * r * rate[12]


@MODERATE
@given(PLANTS, states())
def test_coriolis_forces_do_no_work(params, state):
    none = (0.0, 0.0, 0.0, 0.0)
    free = Model(replace(params, linear_damping=none, quadratic_damping=none))
    assert power(free, state) == pytest.approx(0.0, abs=1e-9 * (1.0 + free.kinetic_energy(state[7:])))


@MODERATE
@given(PLANTS, states())
def test_drag_of_a_real_hull_only_takes_energy(params, state):
    model = Model(params)
    assert power(model, state) <= 1e-9 * (1.0 + model.kinetic_energy(state[7:]))


def test_drag_as_printed_drives_a_hull_that_goes_backwards_fast_enough():
    """Below v = -Y_v / Y_vv = -0.5 m/s the u^2 of (2.10) is anti-damping; with |u| u it is not."""
    backwards = (*STILL, 1.0, 0.0, 0.0, 0.0, 0.0, -0.6, 0.0, 0.0, 0.0, 0.0)
    assert power(Model(plant("table_2_1", drag="thesis")), backwards) > 0.0
    assert power(Model(plant("table_2_1")), backwards) < 0.0
    slowly = (*backwards[:8], -0.4, *backwards[9:])
    assert power(Model(plant("table_2_1", drag="thesis")), slowly) < 0.0


@MODERATE
@given(PLANTS, states(), st.tuples(FORCES, FORCES, FORCES, FORCES))
def test_motion_is_the_printed_equation_in_the_body_frame(params, state, forces):
    """(2.10) with |u| u, and heave."""
    u, v, w, r = state[7], state[8], state[9], state[12]
    m11, m22, _, _ = params.inertia
    C = np.array(
        [[0, 0, 0, -m22 * v], [0, 0, 0, m11 * u], [0, 0, 0, 0], [m22 * v, -m11 * u, 0, 0]], dtype=float
    )
    nu = np.array([u, v, w, r])
    D = np.diag(np.array(params.linear_damping) + np.array(params.quadratic_damping) * np.abs(nu))
    expected = (np.array(forces) - C @ nu - D @ nu) / np.array(params.inertia)
    tau = (forces[0], forces[1], forces[2], 7.0, 8.0, forces[3])
    rate = Model(params).derivative(state, tau, STILL)
    np.testing.assert_allclose([rate[7], rate[8], rate[9], rate[12]], expected, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(C, -C.T)


@MODERATE
@given(states())
def test_the_position_turns_with_the_heading_unless_the_frame_is_flat(state):
    heading = 2.0 * math.atan2(state[6], state[3])
    u, v = state[7], state[8]
    north, east, _ = Model(plant("table_2_1")).derivative(state, NO_FORCE, STILL)[:3]
    assert north == pytest.approx(u * math.cos(heading) - v * math.sin(heading), abs=1e-12)
    assert east == pytest.approx(u * math.sin(heading) + v * math.cos(heading), abs=1e-12)
    flat = Model(plant("table_2_1", frame="flat")).derivative(state, NO_FORCE, STILL)
    assert flat[:3] == state[7:10]


def test_a_hull_at_rest_in_the_water_drifts_with_the_current_whatever_its_heading():
    current = (0.1, -0.05, 0.0)
    model = Model(plant("table_3_1"))
    state = model.initial_state((0.0, 0.0, 5.0), 1.0)
    for _ in range(6000):
        state = model.step(state, NO_FORCE, current, 0.1)
    c, s = math.cos(1.0), math.sin(1.0)
    north, east = c * state[7] - s * state[8], s * state[7] + c * state[8]
    assert (north, east) == pytest.approx(current[:2], abs=0.02)


def test_top_speed_is_the_speed_that_the_actuators_hold():
    model = Model(plant("table_2_1", max_force_n=200.0))
    speed_mps = model.top_speed_mps
    assert 100.0 * speed_mps + 200.0 * speed_mps**2 == pytest.approx(200.0)
    assert Model(plant("table_2_1")).top_speed_mps == math.inf


def test_actuators_clip_axis_by_axis_and_have_no_roll_and_pitch():
    limited = Model(plant("table_2_1", max_force_n=200.0, max_moment_nm=30.0))
    given = limited.limited_command((300.0, -300.0, 100.0, 5.0, 5.0, -50.0))
    assert given == (200.0, -200.0, 100.0, 0.0, 0.0, -30.0)
