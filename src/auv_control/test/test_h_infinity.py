"""Claims about the H-infinity law at run time: where it comes to, what it rejects, what it refuses."""

import math
from typing import Any

import numpy as np
import pytest

from auv_control.avoidance import obstacle_force
from auv_control.controllers import MotionView
from auv_control.controllers.h_infinity import Controller, Params
from auv_control.references import circle
from auv_core.geometry import quaternion_from_heading
from auv_core.integrate import rk4_step
from auv_core.messages import VehicleState
from auv_core.models import four_dof
from auv_core.params import ConfigError, load

STILL = (0.0, 0.0, 0.0)
TABLE_2_1 = {
    "inertia": (215.0, 265.0, 265.0, 80.0),
    "linear_damping": (70.0, 100.0, 100.0, 50.0),
    "quadratic_damping": (100.0, 200.0, 200.0, 100.0),
}
PATH = circle.Reference(circle.Params(depth_m=0.0))
OBSTACLES = (((8.0, 5.0, 0.0), 2.0),)


def _plant(factor=1.0, frame="body"):
    scaled: dict[str, Any] = {
        name: tuple(factor * value for value in values) for name, values in TABLE_2_1.items()
    }
    return four_dof.Model(four_dof.Params(frame=frame, **scaled))


def _view(t_s, plant_state, obstacles=()):
    nav = VehicleState(0, plant_state[:3], plant_state[3:7], plant_state[7:])
    return MotionView(t_s, nav, PATH.at(t_s), (), obstacles)


def _fly(law, plant, *, duration_s, force=(0.0, 0.0), current=STILL, step_s=0.05):
    """Return times, NED position errors (m), values of the candidate, last state of a run from rest."""

    def rates(t_s, state):
        tau, memory_rate = law.evaluate(state[13:], _view(t_s, state[:13]))
        pushed = (tau[0] + force[0], tau[1] + force[1], *tau[2:])
        return (*plant.derivative(state[:13], pushed, current), *memory_rate)

    start = plant.initial_state(STILL, 0.0)
    state = (*start, *law.initial_state(_view(0.0, start)))
    times, errors, values = [], [], []
    for k in range(round(duration_s / step_s)):
        t_s = k * step_s
        values.append(law.lyapunov(state[13:], _view(t_s, state[:13]), plant.kinetic_energy)[0])
        state = rk4_step(rates, t_s, state, step_s)
        state = (*plant.normalised(state[:13]), *law.constrained(state[13:]))
        times.append(t_s + step_s)
        errors.append(math.dist(PATH.at(t_s + step_s).position[:2], state[:2]))
    return np.array(times), np.array(errors), np.array(values), state


@pytest.mark.parametrize(("factor", "frame"), [(1.0, "body"), (0.7, "body"), (1.3, "body"), (1.0, "flat")])
def test_it_comes_to_the_path_of_vehicles_that_differ(factor, frame):
    law = Controller(Params(frame=frame), 0.1)
    times, errors_m, _, _ = _fly(law, _plant(factor, frame), duration_s=100.0)
    assert errors_m[times >= 60.0].max() < 0.012
    assert errors_m[-1] < 0.004


@pytest.mark.parametrize(
    ("force", "current"), [((20.0, -15.0), STILL), ((0.0, 0.0), (0.1, 0.0, 0.0))], ids=["force", "current"]
)
def test_a_steady_disturbance_is_rejected(force, current):
    push = {"duration_s": 150.0, "force": force, "current": current, "step_s": 0.1}
    _, errors_m, _, _ = _fly(Controller(Params(), 0.1), _plant(), **push)
    assert errors_m[-1] < 0.005
    no_integral = Params(surge_gain=(0.0, 309.4, 414.9), sway_gain=(0.0, 319.8, 406.1))
    _, left_m, _, _ = _fly(Controller(no_integral, 0.1), _plant(), **push)
    assert left_m[-1] > 5.0 * errors_m[-1]


def test_candidate_falls_on_a_path_without_obstacles():
    _, _, values, _ = _fly(Controller(Params(), 0.1), _plant(), duration_s=60.0)
    assert (np.diff(values) <= 1e-9 * values.max()).all()


def test_far_from_the_path_the_force_is_bounded_and_nothing_is_integrated():
    law = Controller(Params(), 0.1)
    for start_m in (10.0, 1000.0):
        tau, rate = law.evaluate((0.0, 0.0), _view(0.0, _plant().initial_state((start_m, 0.0, 0.0), 0.0)))
        assert math.hypot(tau[0], tau[1]) < 300.0
        assert rate == (0.0, 0.0)


def test_near_the_path_the_integral_grows_by_the_error_in_ned():
    law = Controller(Params(), 0.1)
    _, rate = law.evaluate((0.0, 0.0), _view(0.0, _plant().initial_state((0.1, 9.8, 0.0), 2.0)))
    assert rate == pytest.approx((-0.1, 0.2))


def test_obstacles_push_with_the_force_of_the_thesis_and_stop_the_integral():
    law = Controller(Params(), 0.1)
    state = _plant().initial_state((8.0, 6.0, 0.0), 0.0)
    free, rate = law.evaluate((0.0, 0.0), _view(93.0, state))
    pushed, stopped = law.evaluate((0.0, 0.0), _view(93.0, state, OBSTACLES))
    force = obstacle_force((8.0, 6.0, 0.0), OBSTACLES, 1.0, truncate=True)
    assert np.subtract(pushed, free)[:2] == pytest.approx(force)
    assert rate != (0.0, 0.0)
    assert stopped == (0.0, 0.0)


def test_integral_acts_along_ned_whatever_the_heading():
    law = Controller(Params(surge_gain=(25.0, 300.0, 400.0), sway_gain=(25.0, 300.0, 400.0)), 0.1)
    for heading_rad in (0.0, 1.0, -2.0):
        state = (*PATH.at(0.0).position, *quaternion_from_heading(heading_rad), *[0.0] * 6)
        tau, _ = law.evaluate((2.0, 0.0), _view(0.0, state))
        still, _ = law.evaluate((0.0, 0.0), _view(0.0, state))
        x, y = np.subtract(tau, still)[:2]
        north = math.cos(heading_rad) * x - math.sin(heading_rad) * y
        assert (north, math.hypot(x, y)) == pytest.approx((50.0, 50.0))


@pytest.mark.parametrize(
    ("raw", "words"),
    [
        ({"surge_gain": [700.0, 300.0, 400.0]}, r"law.surge_gain: .*a stable loop"),
        ({"sway_gain": [25.0, 0.0, 400.0]}, r"law.sway_gain: .*a stable loop"),
        ({"surge_gain": [-1.0, 300.0, 400.0]}, r"law.surge_gain\[0\]: -1.0 is not allowed"),
        (
            {"surge_riccati": [1.0, 2.0, 0.0, 1.0, 0.0, 1.0]},
            "law.surge_riccati: .*a positive definite matrix",
        ),
        ({"achieved_norm": [0.9, 0.7]}, r"law.achieved_norm\[0\]: 0.9 .*at most gamma\[0\]"),
        ({"error_limit_m": 0.0}, "law.error_limit_m: 0.0 is not allowed"),
    ],
)
def test_gains_that_cannot_be_meant_are_refused(raw, words):
    with pytest.raises(ConfigError, match=words):
        load(Params, raw, "law")
