"""Claims about sliding mode and H-infinity under a flocking law, flown on the ODIN model at 10 Hz."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

import auv_core.models
from auv_control.controllers import (
    VelocityReference,
    velocity_h_infinity,
    velocity_pi,
    velocity_sliding_mode,
)
from auv_core.geometry import body_to_ned
from auv_core.messages import VehicleState
from auv_core.models.six_dof import Model
from auv_core.params import ConfigError, load, load_section

PERIOD_S, DT_S = 0.1, 0.02
STILL, CURRENT = (0.0, 0.0, 0.0), (0.2, -0.15, 0.05)
LEVEL = (1.0, 0.0, 0.0, 0.0)
_PRESET = Path(auv_core.models.__file__).parent / "presets" / "odin.yaml"
ODIN = load_section(yaml.safe_load(_PRESET.read_text()), "odin", "auv_core.models").params
both_laws = pytest.mark.parametrize(
    "law", [velocity_sliding_mode, velocity_h_infinity], ids=["sliding mode", "H-infinity"]
)
UNIT = st.floats(-1.0, 1.0)
SMALL = st.floats(-0.1, 0.1)
ATTITUDES = (
    st.tuples(UNIT, UNIT, UNIT, UNIT)
    .filter(lambda q: math.hypot(*q) > 1e-2)
    .map(lambda q: tuple(x / math.hypot(*q) for x in q))
)


def _fly(controller, wanted_at, duration_s, current=CURRENT):
    """Return the velocities over ground (ticks + 1, 3; m/s)."""
    model = Model(ODIN)
    state: Any = model.initial_state((0.0, 0.0, 10.0), 0.0)
    velocities = [STILL]
    for tick in range(round(duration_s / PERIOD_S)):
        nav = VehicleState(tick, state[:3], state[3:7], state[7:])
        command = controller.step(nav, VelocityReference(wanted_at(tick * PERIOD_S), 0.3))
        for _ in range(round(PERIOD_S / DT_S)):
            state = model.step(state, model.limited_command(command.tau), current, DT_S)
        velocities.append(body_to_ned(state[3:7], state[7:10]))
    return np.array(velocities)


@both_laws
def test_a_step_in_velocity_settles_on_it_in_a_current(law):
    wanted = (0.2, 0.1, -0.1)
    velocities = _fly(law.Controller(law.Params(), PERIOD_S), lambda _t_s: wanted, 60.0)
    np.testing.assert_allclose(velocities[300:], np.broadcast_to(wanted, (301, 3)), atol=3e-3)


@both_laws
def test_the_integral_does_not_wind_up_while_the_actuators_are_at_their_limit(law):
    def impossible_then_rest(t_s):
        return (5.0, 0.0, 0.0) if t_s < 40.0 else STILL

    velocities = _fly(law.Controller(law.Params(), PERIOD_S), impossible_then_rest, 60.0)
    assert velocities[400, 0] > 1.5, "the test must hold the actuators at their limit"
    assert velocities[400:, 0].min() > -0.15 * velocities[400, 0]
    assert abs(velocities[-1, 0]) < 0.02


@both_laws
@settings(max_examples=60, deadline=None)
@given(
    attitude=ATTITUDES,
    nu=st.tuples(*[st.floats(-5.0, 5.0)] * 6),
    velocity=st.tuples(*[st.floats(-1e3, 1e3)] * 3),
)
def test_limits_are_held_whatever_is_asked(law, attitude, nu, velocity):
    params = law.Params()
    controller = law.Controller(params, PERIOD_S)
    for tick in range(5):
        tau = controller.step(VehicleState(tick, STILL, attitude, nu), VelocityReference(velocity, 0.5)).tau
        assert np.isfinite(tau).all()
        assert max(map(abs, tau[:3])) <= params.max_force_n
        assert max(map(abs, tau[3:])) <= params.max_moment_nm


@settings(max_examples=60, deadline=None)
@given(nu=st.tuples(SMALL, SMALL, SMALL), held=st.tuples(SMALL, SMALL, SMALL))
def test_within_its_layer_sliding_mode_is_pi_with_the_drag_of_the_model(nu, held):
    reference = VelocityReference((0.05, -0.05, 0.02), 0.0)
    sliding = velocity_sliding_mode.Controller(velocity_sliding_mode.Params(), PERIOD_S)
    pi = velocity_pi.Controller(velocity_pi.Params(), PERIOD_S)
    six = (*nu, 0.0, 0.0, 0.0)
    tau, rate = sliding.evaluate(LEVEL, six, held, reference)
    linear, linear_rate = pi.evaluate(LEVEL, six, held, reference)
    drag = [
        48.0 * abs(speed) * (wanted + 0.31 * q)
        for speed, wanted, q in zip(nu, reference.velocity, held, strict=True)
    ]
    assert np.subtract(tau[:3], drag).tolist() == pytest.approx(list(linear[:3]), rel=2e-3, abs=2e-3)
    assert tau[3:] == linear[3:]
    assert rate == linear_rate


@settings(max_examples=60, deadline=None)
@given(speed=st.floats(-1.5, 1.5), held_m=st.floats(-1.0, 1.0))
def test_candidate_of_sliding_mode_falls_at_the_rate_of_the_proof(speed, held_m):
    """Along surge at a steady command in still water, with q' = e and m nu' = tau - d_Q |nu| nu."""
    p = velocity_sliding_mode.Params(max_force_n=1e6)
    law, wanted, mass_kg = velocity_sliding_mode.Controller(p, PERIOD_S), 0.3, 187.5
    drag = 48.0 * abs(speed)
    error = wanted - speed
    s = error + p.error_rate_ps * held_m
    acceleration = (law.force(0, speed, wanted, held_m) - drag * speed) / mass_kg
    slope_w = mass_kg * s * (-acceleration + p.error_rate_ps * error)
    layer = max(-1.0, min(1.0, s / p.boundary_layer_mps))
    assert slope_w == pytest.approx(-drag * s**2 - p.switching_gain_n * s * layer, abs=1e-9)
    assert slope_w <= 0.0


def test_the_integral_of_sliding_mode_makes_up_for_a_wrong_model():
    """A steady force below k leaves no error in the end, whatever the model says."""
    params = velocity_sliding_mode.Params(
        mass_kg=(131.25, 131.25, 131.25), quadratic_damping=(33.6, 33.6, 33.6)
    )
    velocities = _fly(velocity_sliding_mode.Controller(params, PERIOD_S), lambda _t_s: (0.2, 0.0, 0.0), 60.0)
    assert abs(velocities[-1, 0] - 0.2) < 1e-3


@pytest.mark.parametrize(
    ("law", "raw", "words"),
    [
        (velocity_sliding_mode, {"boundary_layer_mps": 0.0}, "law.boundary_layer_mps: 0.0 is not allowed"),
        (velocity_sliding_mode, {"mass_kg": [1.0, 0.0, 1.0]}, r"law.mass_kg\[1\]: 0.0 is not allowed"),
        (velocity_h_infinity, {"gain": [0.0, 300.0]}, r"law.gain\[0\]: 0.0 is not allowed"),
        (velocity_h_infinity, {"riccati": [1.0, 2.0, 1.0]}, "law.riccati: .*positive definite"),
        (velocity_h_infinity, {"achieved_norm": 0.9}, "law.achieved_norm: 0.9 is not allowed"),
    ],
)
def test_numbers_that_cannot_be_meant_are_refused(law, raw, words):
    with pytest.raises(ConfigError, match=words):
        load(law.Params, raw, "law")
