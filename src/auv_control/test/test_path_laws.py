"""Claims about the PD and the augmented PD path-following laws on the vehicle of thesis Table 2.1."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from auv_control.avoidance import obstacle_force
from auv_control.controllers import MotionView, pfapd, pfpd
from auv_control.references import PathPoint, circle
from auv_core.geometry import quaternion_from_heading
from auv_core.messages import VehicleState
from auv_core.models import four_dof
from auv_core.params import ConfigError, load

M11, M22 = 215.0, 265.0
TABLE_2_1: dict[str, Any] = {
    "inertia": (M11, M22, 265.0, 80.0),
    "linear_damping": (70.0, 100.0, 100.0, 50.0),
    "quadratic_damping": (100.0, 200.0, 200.0, 100.0),
}
LAWS = {"pfpd": pfpd, "pfapd": pfapd}
SMALL = st.floats(-2.0, 2.0)
VECTOR = st.tuples(SMALL, SMALL, SMALL)
ANGLE = st.floats(-3.1, 3.1)
OBSTACLES = (((8.0, 5.0, 0.0), 2.0), ((-9.0, -5.0, 0.0), 2.0))
PATH = circle.Reference(circle.Params(depth_m=0.0))


def _law(kind, **params):
    return LAWS[kind].Controller(LAWS[kind].Params(**params), 0.1)


def _plant(frame, drag="abs"):
    return four_dof.Model(four_dof.Params(frame=frame, drag=drag, **TABLE_2_1))


def _view(t_s, state, obstacles=()):
    nav = VehicleState(0, state[:3], state[3:7], state[7:13])
    return MotionView(t_s, nav, PATH.at(t_s), (), obstacles)


def _state(position, heading_rad, nu):
    return (*position, *quaternion_from_heading(heading_rad), nu[0], nu[1], 0.0, 0.0, 0.0, nu[2])


@pytest.mark.parametrize("kind", LAWS)
@pytest.mark.parametrize("frame", ["flat", "body", "mixed"])
def test_at_rest_beside_a_fixed_point_the_law_is_a_spring_to_it(kind, frame):
    view = MotionView(
        0.0,
        VehicleState(0, (1.0, 2.0, 3.0), quaternion_from_heading(math.pi / 2.0), (0.0,) * 6),
        PathPoint((1.5, 1.0, 9.0), (0.0, 0.0, 0.0)),
    )
    tau, rate = _law(kind, frame=frame).evaluate((), view)
    # Heading east, 0.5 m north is to the left and 1 m west is behind.
    expected = (-100.0, -75.0) if frame == "body" else (50.0, -150.0)
    assert rate == ()
    np.testing.assert_allclose(tau, (*expected, 0.0, 0.0, 0.0, 0.0), atol=1e-12)


@given(position=VECTOR, heading_rad=ANGLE, nu=VECTOR, t_s=st.floats(0.0, 600.0))
def test_pd_in_the_flat_frame_is_the_printed_sum(position, heading_rad, nu, t_s):
    view = _view(t_s, _state(position, heading_rad, nu), OBSTACLES)
    tau, _ = _law("pfpd", frame="flat").evaluate((), view)
    gap, speed = np.subtract(view.path.position, position), np.subtract(view.path.velocity, nu)
    force = obstacle_force(position, OBSTACLES, 1.0, truncate=False)
    np.testing.assert_allclose(
        tau[:2], np.array([100.0, 150.0]) * gap[:2] + np.array([50.0, 40.0]) * speed[:2] + force, atol=1e-9
    )
    assert tau[2:] == (0.0, 0.0, 0.0, 0.0)


@given(position=VECTOR, heading_rad=ANGLE, nu=VECTOR)
def test_the_body_law_does_not_care_where_north_is(position, heading_rad, nu):
    gap, speed, pull = (1.5, -0.7), (0.1, -0.05), (0.01, 0.02)
    forces = []
    for turn in (0.0, 1.0):
        c, s = math.cos(turn), math.sin(turn)
        gap_n, speed_n, pull_n = ((c * x - s * y, s * x + c * y, 0.0) for x, y in (gap, speed, pull))
        nav = VehicleState(
            0, position, quaternion_from_heading(heading_rad + turn), (nu[0], nu[1], 0, 0, 0, nu[2])
        )
        place = (position[0] + gap_n[0], position[1] + gap_n[1], position[2])
        rock = ((position[0] - s - c, position[1] + c - s, 0.0), 2.0)
        view = MotionView(0.0, nav, PathPoint(place, speed_n, pull_n), (), (rock,))
        forces.append(_law("pfapd").evaluate((), view)[0])
    np.testing.assert_allclose(forces[0], forces[1], atol=1e-9)


@given(position=VECTOR, heading_rad=ANGLE, nu=VECTOR, scale=st.floats(0.0, 2.0))
def test_the_augmented_law_adds_the_force_that_the_path_needs(position, heading_rad, nu, scale):
    """On the path, M nu_r' + C nu_r is what the plant needs: the rest of C is turned with it."""
    view = _view(3.0, _state(position, heading_rad, nu))
    augmented, _ = _law("pfapd", damping_scale=scale).evaluate((), view)
    plain, _ = _law("pfpd").evaluate((), view)
    u_r, v_r = np.array(view.path.velocity[:2]) @ _turn(heading_rad).T
    ax, ay = np.array(view.path.acceleration[:2]) @ _turn(heading_rad).T
    r = nu[2]
    surge = scale * (70.0 + 100.0 * abs(nu[0])) * u_r + M11 * (ax + r * v_r) - M22 * r * v_r
    sway = scale * (100.0 + 200.0 * abs(nu[1])) * v_r + M22 * (ay - r * u_r) + M11 * r * u_r
    np.testing.assert_allclose(np.subtract(augmented, plain), [surge, sway, 0, 0, 0, 0], atol=1e-9)


def _turn(heading_rad):
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    return np.array([[c, s], [-s, c]])


@pytest.mark.parametrize("kind", LAWS)
@pytest.mark.parametrize("frame", ["flat", "body"])
@given(position=VECTOR, heading_rad=ANGLE, nu=VECTOR, t_s=st.floats(0.0, 600.0), near=st.booleans())
def test_rate_of_the_corrected_candidate(kind, frame, position, heading_rad, nu, t_s, near):
    """
    V' = -nu_e^T (K_v + D) nu_e + (m22 - m11) r u_e v_e + r (K_x - K_y) x_e y_e - F^T nu_r [+ nu_e^T of the
    feed-forward that the plain law lacks]; the third term only in the body frame.
    """
    if near:
        position = (6.5 + 0.3 * position[0], 4.0 + 0.3 * position[1], 0.0)
    law, plant = _law(kind, frame=frame), _plant(frame)
    state = _state(position, heading_rad, nu)

    def value(state, t_s):
        return law.lyapunov((), _view(t_s, state, OBSTACLES), plant.kinetic_energy)[1]

    tau, _ = law.evaluate((), _view(t_s, state, OBSTACLES))
    rates = plant.derivative(state, tau, (0.0, 0.0, 0.0))
    step_s = 1e-6
    ahead = tuple(x + step_s * k for x, k in zip(state, rates, strict=True))
    behind = tuple(x - step_s * k for x, k in zip(state, rates, strict=True))
    measured = (value(ahead, t_s + step_s) - value(behind, t_s - step_s)) / (2.0 * step_s)
    expected, scale = _rate_in_theory(law, kind, frame, _view(t_s, state, OBSTACLES))
    assert measured == pytest.approx(expected, rel=1e-5, abs=1e-4 * scale)


def _rate_in_theory(law, kind, frame, view):
    turn = (
        _turn(2.0 * math.atan2(view.nav.attitude[3], view.nav.attitude[0])) if frame == "body" else np.eye(2)
    )
    u, v, r = view.nav.nu[0], view.nav.nu[1], view.nav.nu[5]
    x_e, y_e = turn @ np.subtract(view.path.position, view.nav.position)[:2]
    u_r, v_r = turn @ view.path.velocity[:2]
    u_e, v_e = u_r - u, v_r - v
    force = turn @ obstacle_force(view.nav.position, OBSTACLES, 1.0, truncate=False)
    surge, sway = 70.0 + 100.0 * abs(u), 100.0 + 200.0 * abs(v)
    terms = [-(50.0 + surge) * u_e**2, -(40.0 + sway) * v_e**2, (M22 - M11) * r * u_e * v_e]
    terms += [-force[0] * u_r, -force[1] * v_r]
    if frame == "body":
        terms.append(r * (100.0 - 150.0) * x_e * y_e)
    if kind == "pfpd":
        turning = 1.0 if frame == "body" else 0.0
        ax, ay = turn @ view.path.acceleration[:2] + turning * r * np.array([v_r, -u_r])
        terms += [
            u_e * (M11 * ax - M22 * r * v_r + surge * u_r),
            v_e * (M22 * ay + M11 * r * u_r + sway * v_r),
        ]
    return sum(terms), 1.0 + max(abs(term) for term in terms)


def test_thesis_candidates_are_the_printed_ones():
    state = _state((1.0, 8.0, 0.0), 0.5, (0.2, -0.1, 0.3))
    view, plant = _view(0.0, state), _plant("flat")
    x_e, y_e = -1.0, 2.0
    spring = 0.5 * (100.0 * x_e**2 + 150.0 * y_e**2)
    moving = 0.5 * (M11 * 0.2**2 + M22 * 0.1**2 + 80.0 * 0.3**2)
    assert _law("pfpd", frame="flat").lyapunov((), view, plant.kinetic_energy)[0] == pytest.approx(
        spring + moving
    )
    lagging = 0.5 * (M11 * (0.1 - 0.2) ** 2 + M22 * 0.1**2 + 80.0 * 0.3**2)
    value = _law("pfapd", frame="flat").lyapunov((), view, plant.kinetic_energy)[0]
    assert value == pytest.approx(spring + lagging)


def test_a_yaw_gain_turns_towards_the_heading_of_the_path():
    law = _law("pfpd", position_gain=(100.0, 150.0, 30.0), velocity_gain=(50.0, 40.0, 20.0))
    tau, _ = law.evaluate((), _view(0.0, _state((0.0, 10.0, 0.0), 0.0, (0.1, 0.0, 0.2))))
    np.testing.assert_allclose(tau, (0.0, 0.0, 0.0, 0.0, 0.0, 30.0 * math.pi / 3.0 - 20.0 * 0.2), atol=1e-12)


@pytest.mark.parametrize("kind", LAWS)
@pytest.mark.parametrize(
    ("params", "told"),
    [
        ({"position_gain": [100.0, 150.0]}, "position_gain: [100.0, 150.0] is not allowed"),
        ({"position_gain": [100.0, 150.0, 0.0, 1.0]}, "a list of 3 numbers"),
        ({"position_gain": [100.0, -150.0, 0.0]}, "position_gain[1]: -150.0 is not allowed"),
        ({"position_gain": [0.0, 150.0, 0.0]}, "position_gain[0]: 0.0 is not allowed"),
        ({"velocity_gain": [50.0, 40.0, -1.0]}, "velocity_gain[2]: -1.0 is not allowed"),
        ({"velocity_gain": [50.0, math.nan, 0.0]}, "velocity_gain[1]: nan is not allowed"),
        ({"velocity_gain": 50.0}, "velocity_gain: 50.0 is not allowed"),
        ({"frame": "ned"}, "allowed: flat, body, mixed"),
        ({"obstacle_gain_nm": -1.0}, "obstacle_gain_nm: -1.0 is not allowed"),
        ({"gain": 1.0}, "unknown key 'gain'"),
    ],
)
def test_impossible_parameters_are_refused_in_one_line(kind, params, told):
    with pytest.raises(ConfigError) as refused:
        load(LAWS[kind].Params, params, "scenario.agent.controller.params")
    assert told in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "params",
    [
        {"inertia": [215.0, 0.0]},
        {"linear_damping": [70.0, -1.0]},
        {"drag": "square"},
        {"damping_scale": -0.1},
    ],
)
def test_an_impossible_vehicle_in_the_feed_forward_is_refused(params):
    with pytest.raises(ConfigError, match="is not allowed"):
        load(pfapd.Params, params, "params")
