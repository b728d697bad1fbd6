"""Claims about the sliding-mode law: its reaching condition, its boundary layer, what it withstands."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from auv_control.controllers import MotionView
from auv_control.controllers.sliding_mode import Controller, Params
from auv_control.references import circle
from auv_core.geometry import quaternion_from_heading
from auv_core.integrate import rk4_step
from auv_core.messages import VehicleState
from auv_core.models import four_dof
from auv_core.params import ConfigError, load

STILL = (0.0, 0.0, 0.0)
INERTIA, LINEAR, QUADRATIC = (
    (215.0, 265.0, 265.0, 80.0),
    (70.0, 100.0, 100.0, 50.0),
    (100.0, 200.0, 200.0, 100.0),
)
PATH = circle.Reference(circle.Params(depth_m=0.0))
OBSTACLES = (((8.0, 5.0, 0.0), 2.0), ((-9.0, -5.0, 0.0), 2.0))
SMALL = st.floats(-1.5, 1.5)
YAW_STEERED: dict[str, Any] = {"switching_gain": (60.0, 80.0, 20.0)}


def _plant(frame="body", factor=1.0):
    def scaled(values):
        return tuple(factor * value for value in values)

    return four_dof.Model(
        four_dof.Params(
            frame=frame,
            inertia=scaled(INERTIA),
            linear_damping=scaled(LINEAR),
            quadratic_damping=scaled(QUADRATIC),
        )
    )


def _view(t_s, state, obstacles=()):
    nav = VehicleState(0, state[:3], state[3:7], state[7:])
    return MotionView(t_s, nav, PATH.at(t_s), (), obstacles)


def _state(position, heading_rad, u, v, r):
    return (*position, *quaternion_from_heading(heading_rad), u, v, 0.0, 0.0, 0.0, r)


def _fly(law, plant, *, duration_s, disturbance=lambda _t_s: (0.0, 0.0), current=STILL, step_s=0.02):
    """Return times, NED position errors (m) and sliding variables of a run from rest at the origin."""

    def rates(t_s, state):
        tau, _ = law.evaluate((), _view(t_s, state))
        x, y = disturbance(t_s)
        return plant.derivative(state, (tau[0] + x, tau[1] + y, *tau[2:]), current)

    state = plant.initial_state(STILL, 0.0)
    times, errors, sliding = [], [], []
    for k in range(round(duration_s / step_s)):
        t_s = k * step_s
        state = plant.normalised(rk4_step(rates, t_s, state, step_s))
        after_s = t_s + step_s
        times.append(after_s)
        errors.append(math.dist(PATH.at(after_s).position[:2], state[:2]))
        sliding.append(law.sliding_variable(_view(after_s, state)))
    return np.array(times), np.array(errors), np.array(sliding)


@settings(max_examples=60, deadline=None)
@given(
    frame=st.sampled_from(["body", "flat"]),
    is_steered=st.booleans(),
    obstacles=st.sampled_from([(), OBSTACLES]),
    x=st.floats(-12.0, 12.0),
    y=st.floats(-12.0, 12.0),
    heading_rad=st.floats(-3.0, 3.0),
    nu=st.tuples(SMALL, SMALL, st.floats(-0.5, 0.5)),
    t_s=st.floats(0.0, 600.0),
)
def test_candidate_falls_at_the_rate_of_the_proof(frame, is_steered, obstacles, x, y, heading_rad, nu, t_s):
    near = min((math.dist((x, y), centre[:2]) for centre, _ in obstacles), default=9.0)
    assume(near > 0.5 and abs(near - 2.0) > 1e-3)
    plant, law = _plant(frame), Controller(Params(frame=frame, **(YAW_STEERED if is_steered else {})), 0.1)
    state = _state((x, y, 0.0), heading_rad, *nu)
    view = _view(t_s, state, obstacles)
    rates = np.array(plant.derivative(state, law.evaluate((), view)[0], STILL))

    def candidate(step_s):
        after = tuple((np.array(state) + step_s * rates).tolist())
        return law.lyapunov((), _view(t_s + step_s, after, obstacles), plant.kinetic_energy)[0]

    slope_w = (candidate(1e-5) - candidate(-1e-5)) / 2e-5
    s = law.sliding_variable(view)
    gains = law._params.switching_gain
    expected_w = 0.0
    for i, axis in enumerate((0, 1, 3)):
        damping = LINEAR[axis] + QUADRATIC[axis] * abs(nu[i])
        expected_w -= damping * s[i] ** 2 + gains[i] * s[i] * max(-1.0, min(1.0, s[i] / 0.1))
    assert slope_w == pytest.approx(expected_w, rel=1e-4, abs=1e-4 * (1.0 + candidate(0.0)))


@pytest.mark.parametrize(
    ("factor", "kick_n"), [(0.7, (20.0, 25.0)), (1.0, (58.0, 78.0)), (1.3, (20.0, 25.0))]
)
def test_the_boundary_layer_is_not_left_again(factor, kick_n):
    # Plus or minus 30 % of the drag at 0.6 m/s are 23 N and 40 N of k = 60 N and 80 N.
    law = Controller(Params(), 0.1)
    kicks = np.random.default_rng(4).choice([-1.0, 1.0], (200, 2)) * kick_n

    _, errors_m, sliding = _fly(
        law,
        _plant(factor=factor),
        duration_s=50.0,
        disturbance=lambda t_s: tuple(kicks[int(t_s / 0.7)].tolist()),
        step_s=0.025,
    )
    for axis, layer in ((0, 0.1), (1, 0.1)):
        inside = np.abs(sliding[:, axis]) <= layer
        entered = inside.argmax()
        assert inside[entered]
        assert inside[entered:].all()
    assert errors_m[-400:].max() < math.hypot(0.1, 0.1) / 0.5


def test_a_disturbance_above_k_drives_it_out_of_the_layer():
    law = Controller(Params(switching_gain=(20.0, 20.0, 0.0)), 0.1)
    _, _, sliding = _fly(law, _plant(), duration_s=60.0, disturbance=lambda _t_s: (60.0, -60.0), step_s=0.05)
    assert np.abs(sliding[-1, :2]).max() > 0.1


def test_it_comes_to_the_path():
    times, errors_m, sliding = _fly(Controller(Params(), 0.1), _plant(), duration_s=60.0, step_s=0.05)
    assert errors_m[times >= 40.0].max() < 1e-3
    assert np.abs(sliding[-1]).max() < 1e-6


@pytest.mark.parametrize(
    ("factor", "current", "bound_m"),
    [(0.7, STILL, 0.01), (1.3, STILL, 0.01), (1.0, (0.1, 0.0, 0.0), 0.03), (1.3, (0.0, -0.1, 0.0), 0.04)],
    ids=["-30 %", "+30 %", "current", "+30 % and current"],
)
def test_it_withstands_wrong_numbers_and_current(factor, current, bound_m):
    law = Controller(Params(), 0.1)
    times, errors_m, _ = _fly(law, _plant(factor=factor), duration_s=80.0, current=current, step_s=0.05)
    assert errors_m[times >= 50.0].max() < bound_m


def test_what_the_layer_costs():
    wide, narrow = (Controller(Params(boundary_layer=(width, width, 0.1)), 0.1) for width in (0.2, 0.05))
    push = {"duration_s": 60.0, "disturbance": lambda _t_s: (30.0, 0.0), "step_s": 0.05}
    errors_m = [_fly(law, _plant(), **push)[1][-1] for law in (wide, narrow)]
    # s = phi delta / (k + phi d): a steady error of s / lambda
    assert errors_m[0] == pytest.approx(2.0 * 0.2 * 30.0 / (60.0 + 0.2 * 75.0), rel=0.1)
    assert errors_m[1] < 0.3 * errors_m[0]


def test_the_approach_is_bounded():
    law, plant = Controller(Params(), 0.1), _plant()
    for start_m in (10.0, 100.0, 1000.0):
        tau, _ = law.evaluate((), _view(0.0, plant.initial_state((start_m, 0.0, 0.0), 0.0)))
        assert math.hypot(tau[0], tau[1]) < 250.0


def test_obstacles_push_it_aside():
    law, plant = Controller(Params(), 0.1), _plant()
    beside = plant.initial_state((8.0, 5.5, 0.0), 0.0)
    free, _ = law.evaluate((), _view(100.0, beside))
    pushed, _ = law.evaluate((), _view(100.0, beside, OBSTACLES))
    assert pushed[1] > free[1]
    far = plant.initial_state((8.0, 8.5, 0.0), 0.0)
    assert law.evaluate((), _view(100.0, far, OBSTACLES[:1])) == law.evaluate((), _view(100.0, far))


def test_yaw_is_free_or_steered():
    plant = _plant()
    state = _state((0.0, 9.0, 0.0), 0.3, 0.5, 0.4, 0.1)
    assert Controller(Params(), 0.1).evaluate((), _view(0.0, state))[0][5] == 0.0
    law = Controller(Params(**YAW_STEERED), 0.1)

    def rates(t_s, state):
        return plant.derivative(state, law.evaluate((), _view(t_s, state))[0], STILL)

    for k in range(1200):
        state = plant.normalised(rk4_step(rates, 0.05 * k, state, 0.05))
    assert 2.0 * math.atan2(state[6], state[3]) == pytest.approx(math.pi / 3.0, abs=1e-3)


@pytest.mark.parametrize(
    ("raw", "words"),
    [
        ({"switching_gain": [0.0, 80.0, 0.0]}, r"law.switching_gain\[0\]: 0.0 is not allowed"),
        ({"switching_gain": [60.0, 80.0]}, "law.switching_gain: .*a list of 3 numbers"),
        ({"boundary_layer": [0.1, 0.0, 0.1]}, r"law.boundary_layer\[1\]: 0.0 is not allowed; .*above 0"),
        ({"error_rate_ps": -0.5}, "law.error_rate_ps: -0.5 is not allowed"),
        ({"frame": "mixed"}, "law.frame: 'mixed' is not allowed; allowed: body, flat"),
        ({"lambda": 1.0}, "law: unknown key 'lambda'"),
    ],
)
def test_gains_that_cannot_be_meant_are_refused(raw, words):
    with pytest.raises(ConfigError, match=words):
        load(Params, raw, "law")
