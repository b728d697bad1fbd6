"""Claims about the laws for a group in formation: springs between neighbours, sliding mode, H-infinity."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_control.controllers import MotionView, formation_h_infinity, formation_sliding_mode
from auv_control.formation import FormationParams, spring_shift
from auv_control.references import circle
from auv_core.geometry import quaternion_from_heading
from auv_core.integrate import rk4_step
from auv_core.messages import VehicleState
from auv_core.models import four_dof
from auv_core.params import ConfigError, load

STILL = (0.0, 0.0, 0.0)
TABLE_3_1: dict[str, Any] = {
    "inertia": (99.0, 108.5, 126.5, 29.1),
    "linear_damping": (10.0, 0.0, 10.0, 1.603),
    "quadratic_damping": (227.18, 405.42, 227.18, 12.937),
}
PATHS = [circle.Reference(circle.Params(radius_m=10.0 * ring, depth_m=10.0)) for ring in (1, 2, 3)]
LAWS = [formation_sliding_mode, formation_h_infinity]
both_laws = pytest.mark.parametrize("law", LAWS, ids=["sliding mode", "H-infinity"])
COORDINATES = st.floats(-50.0, 50.0)
POINTS = st.tuples(COORDINATES, COORDINATES, COORDINATES)


def _plant(factor=1.0):
    scaled: dict[str, Any] = {
        name: tuple(factor * value for value in values) for name, values in TABLE_3_1.items()
    }
    return four_dof.Model(four_dof.Params(**scaled))


def _nav(state):
    return VehicleState(0, state[:3], state[3:7], state[7:])


def _view(t_s, state, path=PATHS[0], neighbours=()):
    return MotionView(t_s, _nav(state), path.at(t_s), tuple(neighbours))


def _fly(laws, plants, starts, *, duration_s, forces=(), step_s=0.05):
    """Return positions (K + 1, n, 3) of vehicles that see each other; `forces` (N; surge, sway) stay."""
    states = [plant.initial_state(start, 0.0) for plant, start in zip(plants, starts, strict=True)]
    pushes = forces or [(0.0, 0.0)] * len(laws)
    kept = [
        law.initial_state(_view(0.0, state, path))
        for law, state, path in zip(laws, states, PATHS, strict=False)
    ]
    places = [[state[:3] for state in states]]
    for k in range(round(duration_s / step_s)):
        t_s, seen = k * step_s, [state[:3] for state in states]
        for i, law in enumerate(laws):
            view = _view(t_s, states[i], PATHS[i], seen[:i] + seen[i + 1 :])
            tau, rate = law.evaluate(kept[i], view)
            pushed = (tau[0] + pushes[i][0], tau[1] + pushes[i][1], *tau[2:])
            states[i] = plants[i].step(states[i], pushed, STILL, step_s)
            kept[i] = law.constrained(tuple(z + step_s * dz for z, dz in zip(kept[i], rate, strict=True)))
        places.append([state[:3] for state in states])
    return np.array(places)


def _path_errors_m(places, index, step_s=0.05):
    wanted = [PATHS[index].at(k * step_s).position for k in range(len(places))]
    return np.linalg.norm(places[:, index] - wanted, axis=-1)


@given(POINTS, st.lists(POINTS, max_size=4))
def test_springs_shift_the_point_no_farther_than_their_limit(own, others):
    view = _view(0.0, (*own, 1.0, *(0.0,) * 9), neighbours=others)
    assert math.hypot(*spring_shift(view, FormationParams())) <= FormationParams().shift_limit_m + 1e-12
    assert spring_shift(view, FormationParams(coupling_weight=0.0)) == STILL


@pytest.mark.parametrize(
    ("range_m", "shift_m"),
    [(10.0, 0.0), (10.5, 0.25), (9.5, -0.25), (14.0, 1.0), (2.0, -1.0), (15.5, 0.0), (0.0, 0.0)],
    ids=["in place", "far", "near", "far, limited", "near, limited", "beyond reach", "same place"],
)
def test_a_neighbour_pulls_or_pushes_along_the_line(range_m, shift_m):
    view = _view(0.0, (*STILL, 1.0, *(0.0,) * 9), neighbours=[(0.0, range_m, 0.0)])
    assert spring_shift(view, FormationParams()) == pytest.approx((0.0, shift_m, 0.0))


def test_the_middle_of_a_formation_follows_the_mean_of_its_neighbours():
    view = _view(0.0, (*STILL, 1.0, *(0.0,) * 9), neighbours=[(10.4, 0.0, 0.0), (-10.0, 0.0, 0.0)])
    assert spring_shift(view, FormationParams()) == pytest.approx((0.1, 0.0, 0.0))


@settings(max_examples=60, deadline=None)
@given(
    place=st.tuples(st.floats(-3.0, 3.0), st.floats(7.0, 13.0), st.floats(8.0, 12.0)),
    heading_rad=st.floats(-3.0, 3.0),
    nu=st.tuples(*[st.floats(-1.0, 1.0)] * 3, st.floats(-0.4, 0.4)),
)
def test_candidate_of_sliding_mode_falls_at_the_rate_of_the_proof(place, heading_rad, nu):
    plant, law = _plant(), formation_sliding_mode.Controller(formation_sliding_mode.Params(blend_s=0.0), 0.1)
    state = (*place, *quaternion_from_heading(heading_rad), nu[0], nu[1], nu[2], 0.0, 0.0, nu[3])
    rates = np.array(plant.derivative(state, law.evaluate((), _view(0.0, state))[0], STILL))

    def candidate(step_s):
        after = tuple((np.array(state) + step_s * rates).tolist())
        return law.lyapunov((), _view(step_s, after), plant.kinetic_energy)[0]

    slope_w = (candidate(1e-5) - candidate(-1e-5)) / 2e-5
    expected_w = 0.0
    for axis, (s, speed) in enumerate(zip(law.sliding_variable((), _view(0.0, state)), nu, strict=True)):
        damping = TABLE_3_1["linear_damping"][axis] + TABLE_3_1["quadratic_damping"][axis] * abs(speed)
        k = formation_sliding_mode.Params().switching_gain[axis]
        expected_w -= damping * s**2 + k * s * max(-1.0, min(1.0, s / 0.2))
    assert slope_w == pytest.approx(expected_w, rel=1e-4, abs=1e-4 * (1.0 + candidate(0.0)))
    assert expected_w <= 0.0


def test_candidate_of_h_infinity_falls_near_the_path():
    plant, law = _plant(), formation_h_infinity.Controller(formation_h_infinity.Params(blend_s=0.0), 0.1)

    def rates(t_s, state):
        tau, rate = law.evaluate(state[13:], _view(t_s, state[:13]))
        return (*plant.derivative(state[:13], tau, STILL), *rate)

    point = PATHS[0].at(0.0)
    turned = quaternion_from_heading(point.heading_rad + 0.05)
    start = plant.initial_state((0.15, 10.1, 10.1), 0.0)
    state, values = (*start[:3], *turned, *start[7:], 0.0, 0.0, 0.0, 0.0), []
    for k in range(400):
        view = _view(0.05 * k, state[:13])
        values.append(law.lyapunov(state[13:], view, plant.kinetic_energy)[0])
        state = rk4_step(rates, 0.05 * k, state, 0.05)
    assert np.diff(values).max() < 1e-9
    assert values[-1] < 0.2 * values[0]


@both_laws
@pytest.mark.parametrize("factor", [0.7, 1.0, 1.3])
def test_a_vehicle_alone_comes_to_its_path(law, factor):
    made = law.Controller(law.Params(), 0.05)
    places = _fly([made], [_plant(factor)], [(-6.0, 0.0, 0.0)], duration_s=80.0)
    assert _path_errors_m(places, 0)[-200:].max() < 0.03


def test_h_infinity_removes_the_error_of_a_steady_force_and_sliding_mode_bounds_it():
    left_m = {}
    for law in LAWS:
        made = law.Controller(law.Params(), 0.05)
        places = _fly(
            [made], [_plant()], [PATHS[0].at(0.0).position], duration_s=80.0, forces=[(15.0, -10.0)]
        )
        left_m[law] = _path_errors_m(places, 0)[-1]
    assert left_m[formation_h_infinity] < 0.01
    # s = phi delta / k in the layer, and an error of s / lambda
    assert 0.03 < left_m[formation_sliding_mode] < 0.2 * math.hypot(15.0, 10.0) / 40.0 / 0.5


@both_laws
def test_coupling_keeps_distances_when_one_vehicle_is_pushed(law):
    starts = [path.at(0.0).position for path in PATHS]
    errors_m = []
    for weight in (0.0, 0.5):
        laws = [law.Controller(law.Params(coupling_weight=weight), 0.05) for _ in starts]
        places = _fly(
            laws, [_plant()] * 3, starts, duration_s=40.0, forces=[(20.0, 20.0), (0.0, 0.0), (0.0, 0.0)]
        )
        distances = np.linalg.norm(np.diff(places, axis=1), axis=-1)
        errors_m.append(float(np.abs(distances - 10.0).max()))
    assert errors_m[1] < 0.85 * errors_m[0]


@both_laws
def test_the_force_limit_is_kept_and_the_integral_waits(law):
    made = law.Controller(law.Params(max_force_n=10.0, blend_s=0.0), 0.05)
    view = _view(0.0, _plant().initial_state((0.4, 10.0, 10.0), 0.0))
    tau, rate = made.evaluate(made.initial_state(view), view)
    assert max(abs(force) for force in tau[:3]) == 10.0
    assert set(rate) <= {0.0}


@both_laws
@pytest.mark.parametrize(
    ("raw", "words"),
    [
        ({"coupling_weight": -0.1}, "law.coupling_weight: -0.1 is not allowed"),
        ({"frame": "flat"}, "law.frame: 'flat' is not allowed; allowed: body"),
        ({"inertia": [99.0, 108.5, 126.5]}, "law.inertia: .*a list of 4 numbers"),
    ],
)
def test_numbers_that_cannot_be_meant_are_refused(law, raw, words):
    with pytest.raises(ConfigError, match=words):
        load(law.Params, raw, "law")


@pytest.mark.parametrize(
    ("raw", "words"),
    [
        ({"yaw_gain": [100.0, 1.0, 1.0]}, r"law.yaw_gain: \[100.0, 1.0, 1.0\] is not allowed; .*stable loop"),
        ({"heave_riccati": [1.0, 2.0, 0.0, 1.0, 0.0, 1.0]}, "law.heave_riccati: .*positive definite"),
        ({"achieved_norm": [0.7, 0.7, 0.7, 0.9]}, r"law.achieved_norm\[3\]: 0.9 is not allowed"),
    ],
)
def test_feedback_without_a_certificate_is_refused(raw, words):
    with pytest.raises(ConfigError, match=words):
        load(formation_h_infinity.Params, raw, "law")


def test_a_formation_needs_a_path():
    made = formation_sliding_mode.Controller(formation_sliding_mode.Params(), 0.05)
    with pytest.raises(ValueError, match="a view without a path is not allowed"):
        made.initial_state(MotionView(0.0, _nav(_plant().initial_state(STILL, 0.0)), None))
