"""Claims about a hull with thrusters: how forces follow their demands, and how the hull moves by them."""

import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import auv_core.models
from auv_core.compiled import _compiled
from auv_core.models._thruster_drive import advance_driven, put_delivered
from auv_core.models.six_dof import Model, Params
from auv_core.params import ConfigError, load

STILL = (0.0, 0.0, 0.0)
CURRENT = (0.1, -0.2, 0.05)


def params_of(preset, **changes):
    path = Path(str(auv_core.models.__file__)).parent / f"presets/{preset}.yaml"
    return load(Params, {**yaml.safe_load(path.read_text(encoding="utf-8"))["params"], **changes}, preset)


ODIN = Model(params_of("odin", actuators="thrusters"))
BLUEROV2 = Model(params_of("bluerov2_heavy"))
models = st.sampled_from([ODIN, BLUEROV2])
demands = st.tuples(*[st.floats(-200.0, 200.0)] * 8)


def test_by_default_odin_takes_a_wrench_and_has_no_state_of_actuators():
    model = Model(params_of("odin"))
    assert model.command == "wrench"
    assert model.actuators == ()
    assert len(model.initial_state(STILL, 0.0)) == 13


def test_thrusters_have_names_a_unit_and_a_state():
    assert ODIN.command == "thrusters"
    assert [each.name for each in ODIN.actuators] == [f"thruster_{k}" for k in range(1, 9)]
    assert {each.unit for each in ODIN.actuators} == {"N"}
    assert ODIN.initial_state(STILL, 0.0)[13:] == ODIN.resting_command() == (0.0,) * 8


def test_odins_thrusters_hold_at_least_the_speed_of_its_box_of_forces():
    assert Model(params_of("odin")).top_speed_mps < ODIN.top_speed_mps
    assert ODIN.speed_held_mps(150.0) == Model(params_of("odin")).top_speed_mps


@given(models, demands)
def test_the_forces_follow_their_demands_with_the_lag(model, demand):
    ends = model.limited_command(demand)
    thrusters = model.params.thrusters
    assert all(thrusters.lowest_n <= ends)
    assert all(ends <= thrusters.highest_n)
    state = model.step(model.initial_state(STILL, 0.0), ends, STILL, 0.02, 25)
    share = -math.expm1(-25 * 0.02 / thrusters.lag_s)
    np.testing.assert_allclose(state[13:], share * np.array(ends), rtol=1e-12)


@pytest.mark.parametrize("model", [ODIN, BLUEROV2], ids=["odin", "bluerov2_heavy"])
def test_the_motion_is_that_of_the_differential_equation(model):
    """Against an integrator that has the forces in its state; the tolerance is for the lag within a step."""
    state = model.initial_state((1.0, 2.0, 10.0), 0.4)
    for demand in (
        (20.0, 5.0, -10.0, 3.0, 8.0, -5.0, 10.0, 2.0),
        (-5.0, 30.0, 4.0, -9.0, 0.0, 6.0, -8.0, 1.0),
    ):
        ends = model.limited_command(demand)
        exact = solve_ivp(
            lambda _t, x, ends=ends: model.derivative(tuple(x.tolist()), ends, CURRENT),
            (0.0, 0.3),
            state,
            rtol=1e-8,
            atol=1e-9,
        )
        state = model.step(state, ends, CURRENT, 0.01, 30)
        np.testing.assert_allclose(state, exact.y[:, -1], atol=1e-3)


def test_halving_the_step_quarters_the_error_of_the_lag():
    ends = BLUEROV2.limited_command((30.0, 10.0, -20.0, 5.0, 15.0, -5.0, 10.0, 20.0))
    start = BLUEROV2.initial_state(STILL, 0.0)
    flown = [np.array(BLUEROV2.step(start, ends, STILL, 0.3 / n, n)) for n in (15, 30, 60, 960)]
    errors = [np.abs(state - flown[-1]).max() for state in flown[:-1]]
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.3)
    assert errors[1] / errors[2] == pytest.approx(4.0, abs=0.3)


def test_compiled_thrusters_give_the_same_to_the_last_bit():
    compiled = Model(BLUEROV2.params)
    assert compiled._drive is not None
    compiled._drive._advance = _compiled(advance_driven)
    compiled._drive._put_delivered = _compiled(put_delivered)
    plain = Model(params_of("bluerov2_heavy"))
    rng, state = np.random.default_rng(3), plain.initial_state(STILL, 0.3)
    for _ in range(30):
        demand = tuple(rng.uniform(-60.0, 60.0, 8).tolist())
        ends = plain.limited_command(demand)
        assert compiled.limited_command(demand) == ends
        after = plain.step(state, ends, CURRENT, 0.02, 5)
        assert compiled.step(state, ends, CURRENT, 0.02, 5) == after
        state = after


def test_a_hull_without_thrusters_cannot_be_flown_with_them():
    with pytest.raises(ConfigError, match=r"^odin_heavy\.actuators: 'thrusters' is not allowed; allowed: wr"):
        params_of("odin_heavy", actuators="thrusters")
