"""Claims about the law into a ring: its wrench, its energy, its attitudes without a singular pitch."""

import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

import auv_core.models
from auv_control.controllers import MotionView
from auv_control.controllers.gcpd import Controller, Params
from auv_core.geometry import body_to_ned
from auv_core.integrate import rk4_step
from auv_core.messages import VehicleState
from auv_core.models.six_dof import Model
from auv_core.params import ConfigError, load, load_section

ZERO6 = (0.0,) * 6
STILL = (0.0, 0.0, 0.0)
LEVEL = (1.0, 0.0, 0.0, 0.0)
ATTITUDES = (
    st.tuples(*[st.floats(-1.0, 1.0)] * 4)
    .filter(lambda q: math.hypot(*q) > 1e-2)
    .map(lambda q: tuple(x / math.hypot(*q) for x in q))
)


def _odin():
    file = Path(auv_core.models.__file__).parent / "presets/odin_heavy.yaml"
    return Model(load_section(yaml.safe_load(file.read_text()), "model", "auv_core.models").params)


def _view(position, attitude=LEVEL, nu=ZERO6, neighbours=()):
    return MotionView(0.0, VehicleState(0, position, attitude, nu), None, neighbours)


def _wrench(params, *view):
    return Controller(params, 0.1).evaluate((), _view(*view))[0]


def _pitched(angle_rad):
    return (math.cos(0.5 * angle_rad), 0.0, math.sin(0.5 * angle_rad), 0.0)


def test_wrench_by_hand():
    # 1 m above the ring's top: f3 = 1.5^2 - 0.25 = 2 m^2, k_p k_l f3 2 dz = 55 * 0.1 * 2 * 3 = 33 N down
    params = Params(gravity_compensation=False)
    np.testing.assert_allclose(
        _wrench(params, (11.0, 10.0, 8.5)), (0.0, 0.0, 33.0, 0.0, 0.0, 0.0), atol=1e-12
    )
    # a neighbour 0.4 m to the north: 55 * 2 * 103.2 N to the south (see test_region)
    pushed = _wrench(params, (11.0, 10.0, 10.0), LEVEL, ZERO6, ((11.4, 10.0, 10.0),))
    np.testing.assert_allclose(pushed, (-11352.0, 0.0, 0.0, 0.0, 0.0, 0.0), atol=1e-9)
    moving = _wrench(params, (11.0, 10.0, 10.0), LEVEL, (1.0, 2.0, 3.0, 0.1, 0.2, 0.3))
    np.testing.assert_allclose(moving, (-30.0, -60.0, -90.0, -3.0, -6.0, -9.0), atol=1e-12)


def test_weight_and_buoyancy_are_those_of_table_4_1():
    params, plant = Params(), _odin().params
    mass_kg, radius_m, density_kgpm3, gravity_mps2 = 125.0, 0.3, 1000.0, 9.81
    assert params.weight_n == plant.weight_n == pytest.approx(mass_kg * gravity_mps2)
    assert params.buoyancy_n == plant.buoyancy_n
    assert params.buoyancy_n == pytest.approx(
        4.0 / 3.0 * math.pi * radius_m**3 * density_kgpm3 * gravity_mps2
    )
    assert params.weight_n - params.buoyancy_n == pytest.approx(116.77, abs=0.01)
    assert (plant.mass_kg, plant.cog_z_m, plant.hull_radius_m) == (mass_kg, 0.05, radius_m)


@settings(max_examples=50, deadline=None)
@given(ATTITUDES)
def test_gravity_compensation_holds_a_hull_in_any_attitude(attitude):
    plant = _odin()
    inside = (11.5, 10.0, 10.0)
    tau = _wrench(Params(), inside, attitude)
    rates = plant.derivative((*inside, *attitude, *ZERO6), tau, STILL)
    np.testing.assert_allclose(rates, 0.0, atol=1e-12)


@settings(max_examples=50, deadline=None)
@given(ATTITUDES, st.tuples(*[st.floats(5.0, 15.0)] * 3))
def test_steering_force_does_not_depend_on_attitude(attitude, position):
    params = Params(gravity_compensation=False)
    turned = _wrench(params, position, attitude)
    level = _wrench(params, position)
    np.testing.assert_allclose(body_to_ned(attitude, turned[:3]), level[:3], rtol=1e-9, atol=1e-7)
    assert turned[3:] == (0.0, 0.0, 0.0)


@settings(max_examples=30, deadline=None)
@given(ATTITUDES, st.tuples(*[st.floats(-2.0, 2.0)] * 6), st.tuples(*[st.floats(7.0, 13.0)] * 3))
def test_energy_falls_at_the_power_of_both_dampings(attitude, nu, position):
    plant, law = _odin(), Controller(Params(), 0.1)
    fixed = (10.9, 10.2, 9.8)

    def energy(state):
        view = _view(state[:3], state[3:7], state[7:], (fixed,))
        other = _view(fixed, LEVEL, ZERO6, (state[:3],))
        return law.lyapunov((), view, plant.kinetic_energy)[0] + law.lyapunov((), other, lambda _nu: 0.0)[0]

    state = (*position, *attitude, *nu)
    tau, _ = law.evaluate((), _view(position, attitude, nu, (fixed,)))
    rates = np.array(plant.derivative(state, tau, STILL))
    step_s = 1e-6
    ahead, behind = (tuple((np.array(state) + sign * step_s * rates).tolist()) for sign in (1.0, -1.0))
    slope_w = (energy(ahead) - energy(behind)) / (2.0 * step_s)
    p = plant.params
    drag_w = sum(q * abs(a) * a * a for q, a in zip(p.quadratic_damping, nu, strict=True))
    brake_w = sum(30.0 * a * a for a in nu)
    assert slope_w == pytest.approx(-drag_w - brake_w, abs=1e-5 * (abs(slope_w) + energy(state) + 1.0))


def _euler_rates_matrix(attitude):
    """Return J2 of thesis Eqs. (2.6)-(2.7), from the roll and pitch angles of an attitude."""
    w, x, y, z = attitude
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
    s, c, t = math.sin(roll), math.cos(roll), math.tan(pitch)
    return np.array([[1.0, s * t, c * t], [0.0, c, -s], [0.0, s / math.cos(pitch), c / math.cos(pitch)]])


def test_pitching_through_90_degrees():
    plant, law = _odin(), Controller(Params(), 0.1)
    step_s = 0.002

    def rates(_t_s, state):
        tau, _ = law.evaluate((), _view(state[:3], state[3:7], state[7:]))
        return plant.derivative(state, tau, STILL)

    state = (6.0, 10.0, 12.0, *_pitched(math.radians(80.0)), 0.0, 0.0, 0.0, 0.02, 4.0, 0.01)
    forward_down, largest_rate, largest_entry = [], 0.0, 0.0
    for _ in range(1000):
        state = plant.normalised(rk4_step(rates, 0.0, state, step_s))
        assert all(math.isfinite(value) for value in state)
        assert math.hypot(*state[3:7]) == pytest.approx(1.0, abs=1e-12)
        forward_down.append(body_to_ned(state[3:7], (0.0, 0.0, 1.0))[2])
        largest_rate = max(largest_rate, max(map(abs, rates(0.0, state)[3:7])))
        largest_entry = max(largest_entry, np.abs(_euler_rates_matrix(state[3:7])).max())
    assert forward_down[0] > 0.0 > forward_down[-1], "the hull is upside down past 90 degrees"
    assert largest_rate < 3.0
    assert largest_entry > 100.0


def test_euler_rates_have_no_bound_where_the_law_does_not_notice():
    near, at = _pitched(math.radians(90.0 - 1e-7)), _pitched(math.radians(90.0))
    assert np.abs(_euler_rates_matrix(near)).max() > 1e8
    np.testing.assert_allclose(_wrench(Params(), STILL, near), _wrench(Params(), STILL, at), rtol=1e-6)


def test_force_limit_leaves_the_weight_out():
    params = Params(max_force_n=200.0)
    tau = _wrench(params, (5.0, 0.0, 20.0), _pitched(0.4), (1.0, 0.0, 0.0, 0.1, 0.0, 0.0))
    carried = _wrench(params, (11.5, 10.0, 10.0), _pitched(0.4))
    assert math.dist(tau[:3], carried[:3]) == pytest.approx(200.0)
    assert tau[3:] == pytest.approx((-3.0, *carried[4:]))
    free = _wrench(Params(), (5.0, 0.0, 20.0), _pitched(0.4), (1.0, 0.0, 0.0, 0.1, 0.0, 0.0))
    assert np.cross(np.subtract(free[:3], carried[:3]), np.subtract(tau[:3], carried[:3])) == pytest.approx(
        np.zeros(3), abs=1e-6
    )


@pytest.mark.parametrize(
    ("raw", "words"),
    [
        ({"layer_gains_pm3": [500.0, 100.0]}, "law.layer_gains_pm3: .*inner layers repel more strongly"),
        ({"layer_radii_m": [0.5, 1.0]}, "law.layer_radii_m: .*smaller than the one before"),
        ({"layer_radii_m": [1.0]}, "law.layer_gains_pm3: 2 gains are not allowed; .*each of the 1 radii"),
        ({"inner_radius_m": 2.5}, "law.inner_radius_m: 2.5 .*less than outer_radius_m = 2.5"),
        ({"region_gain_pm3": -0.1}, "law.region_gain_pm3: -0.1 is not allowed"),
        ({"damping_gain": [30.0] * 5}, "law.damping_gain: .*a list of 6 numbers"),
        ({"damping_gain": [-1.0] * 6}, r"law.damping_gain\[0\]: -1.0 is not allowed"),
        ({"force_gain_n": float("nan")}, "law.force_gain_n: nan is not allowed"),
    ],
)
def test_gains_that_cannot_be_meant_are_refused(raw, words):
    with pytest.raises(ConfigError, match=words):
        load(Params, raw, "law")


def test_equal_layer_gains_are_allowed():
    assert load(Params, {"layer_gains_pm3": [0.1, 0.1]}, "law").layers == ((1.0, 0.1), (0.5, 0.1))
