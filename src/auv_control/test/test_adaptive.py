"""Claims about the adaptive law of chapter 3, one instant at a time; its flights: auv_experiment/test."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

import auv_control.controllers
from auv_control.body_regressor import body_forces, transposed_times
from auv_control.controllers import MotionView
from auv_control.controllers.adaptive import Controller, Params
from auv_control.references import PathPoint
from auv_core.geometry import quaternion_from_heading
from auv_core.messages import VehicleState
from auv_core.models.four_dof import Model
from auv_core.models.four_dof import Params as Plant
from auv_core.params import load

MODERATE = settings(max_examples=80, deadline=None)
NOMINAL: dict[str, Any] = {
    "inertia": (99.0, 108.5, 126.5, 29.1),
    "linear_damping": (10.0, 0.0, 10.0, 1.603),
    "quadratic_damping": (227.18, 405.42, 227.18, 12.937),
}
TRUE = (*NOMINAL["inertia"], *NOMINAL["linear_damping"], *NOMINAL["quadratic_damping"])
STILL_WATER = (0.0, 0.0, 0.0)


def vectors(size, largest):
    return st.tuples(*[st.floats(-largest, largest)] * size)


@st.composite
def views(draw):
    """Any place and motion of a level vehicle near any place and motion of a path."""
    place, speed = draw(vectors(4, 5.0)), draw(vectors(4, 1.0))
    return MotionView(
        draw(st.floats(0.0, 100.0)),
        VehicleState(0, place[:3], quaternion_from_heading(place[3]), (*speed[:3], 0.0, 0.0, speed[3])),
        PathPoint(
            draw(vectors(3, 5.0)),
            draw(vectors(3, 1.0)),
            draw(vectors(3, 0.2)),
            draw(st.floats(-4.0, 4.0)),
            draw(st.floats(-0.3, 0.3)),
            draw(st.floats(-0.1, 0.1)),
        ),
    )


def preset(name):
    """Return a law by its preset."""
    folder = Path(auv_control.controllers.__file__).parent / "presets"
    return Controller(
        load(Params, yaml.safe_load((folder / f"{name}.yaml").read_text())["params"], name), 0.05
    )


def flat_view(
    error, error_rate, *, velocity=(0.1, 0.2, -0.3), acceleration=(0.01, 0.02, 0.03), turn=(0.0, 0.0)
):
    """Return a view with given e and e' (four-vectors) to a path through the origin."""
    heading, (rate, extra) = 0.4, turn
    nu: Any = tuple(v + e for v, e in zip(velocity, error_rate[:3], strict=True))
    return MotionView(
        3.0,
        VehicleState(
            0, error[:3], quaternion_from_heading(heading + error[3]), (*nu, 0.0, 0.0, rate + error_rate[3])
        ),
        PathPoint((0.0, 0.0, 0.0), velocity, acceleration, heading, rate, extra),
    )


# --- the printed law -------------------------------------------------------------------------------------


def test_the_printed_law_is_its_equations():
    """Worked from (3.10)-(3.12), (3.19) and Table 3.1 with Y, a^, K_D, LAM and GAM as matrices."""
    law = preset("adaptive_thesis")
    view = flat_view((0.5, -0.4, 0.3, -0.2), (0.05, 0.06, -0.07, 0.08), turn=(0.1, -0.02))
    velocity, acceleration = np.array([0.1, 0.2, -0.3, 0.1]), np.array([0.01, 0.02, 0.03, -0.02])
    Y = np.zeros((4, 8))
    for i in range(4):
        Y[i, 2 * i : 2 * i + 2] = acceleration[i], abs(velocity[i]) * velocity[i]
    s = np.array([0.05, 0.06, -0.07, 0.08]) + np.array([50, 10, 20, 20]) * [0.5, -0.4, 0.3, -0.2]
    estimates = np.array([99.0, 227.18, 108.5, 405.42, 126.5, 227.18, 29.1, 12.937])
    state = law.initial_state(view)
    assert state == tuple(estimates)
    tau, rate = law.evaluate(state, view)
    np.testing.assert_allclose(
        (tau[0], tau[1], tau[2], tau[5]), Y @ estimates - np.array([10, 20, 50, 10]) * s, rtol=1e-9
    )
    np.testing.assert_allclose(rate, -np.array([200, 10, 20, 0, 0, 0, 10, 10]) * (Y.T @ s), atol=1e-12)
    assert tau[3:5] == (0.0, 0.0)


def test_the_two_readings_of_gamma_adapt_different_parameters():
    view = flat_view((0.5, -0.4, 0.3, -0.2), (0.0, 0.0, 0.0, 0.0), turn=(0.1, -0.02))
    moving = {}
    for name in ("adaptive_thesis", "adaptive_thesis_grouped_gamma"):
        law = preset(name)
        rates = law.evaluate(law.initial_state(view), view)[1]
        moving[name] = [word for word, rate in zip(law.params.names, rates, strict=True) if rate]
    assert moving["adaptive_thesis"] == ["m11", "dQ1", "m22", "m44", "dQ4"]
    assert moving["adaptive_thesis_grouped_gamma"] == ["m11", "m22", "m33", "dQ3", "dQ4"]


def test_table_3_1_is_far_from_passive():
    """K_D + d_L >= M LAM is what passivity from Y a~ to s needs at rest; the printed gains miss it."""
    p = preset("adaptive_thesis").params
    have = np.array(p.error_gain) + NOMINAL["linear_damping"]
    need = np.array(p.nominal_inertia) * p.error_rate_ps
    np.testing.assert_allclose(have, [20.0, 20.0, 60.0, 11.603])
    np.testing.assert_allclose(need, [4950.0, 1085.0, 2530.0, 582.0])
    assert (need / have).min() == pytest.approx(42.2, abs=0.1)
    assert (need / have).max() == pytest.approx(247.5, abs=0.1)


def test_the_first_force_is_stiffness_times_distance():
    """z: 50 x 20 x 10 m = 10 kN, the peak of Fig. 3.7."""
    law = preset("adaptive_thesis")
    view = flat_view(
        (0.0, 0.0, -10.0, 0.0), (0.0, 0.0, 0.0, 0.0), velocity=STILL_WATER, acceleration=STILL_WATER
    )
    assert law.evaluate(law.initial_state(view), view)[0][2] == pytest.approx(10000.0)


@MODERATE
@given(views())
def test_body_and_mixed_frames_turn_the_forces_and_do_not(view):
    laws = {
        frame: Controller(replace(preset("adaptive_thesis").params, frame=frame), 0.05)
        for frame in ("body", "mixed")
    }
    taus = {frame: law.evaluate(law.initial_state(view), view)[0] for frame, law in laws.items()}
    assert math.hypot(*taus["body"][:2]) == pytest.approx(math.hypot(*taus["mixed"][:2]), rel=1e-9)
    assert taus["body"][2:] == taus["mixed"][2:]
    qw, qz = view.nav.attitude[0], view.nav.attitude[3]
    turn = complex(qw, -qz) ** 2
    assert complex(*taus["body"][:2]) == pytest.approx(complex(*taus["mixed"][:2]) * turn, rel=1e-9, abs=1e-9)


# --- the corrected law -----------------------------------------------------------------------------------


@MODERATE
@given(vectors(12, 3.0), vectors(4, 2.0), vectors(4, 2.0), vectors(4, 1.0), vectors(4, 1.0))
def test_the_two_uses_of_the_regressor_are_transposes(a, nu, nu_r, rate, s):
    through_forces = np.dot(s, body_forces(a, nu, nu_r, rate))
    assert through_forces == pytest.approx(np.dot(transposed_times(nu, nu_r, rate, s), a), abs=1e-9)


@MODERATE
@given(vectors(4, 2.0), vectors(4, 2.0))
def test_coriolis_in_the_regressor_does_no_work(nu, s):
    """M' - 2 C is skew-symmetric for a constant M: s^T C(nu) s = 0, the damping moved out (thesis (3.29))."""
    masses = (*NOMINAL["inertia"], *[0.0] * 8)
    assert np.dot(s, body_forces(masses, nu, s, (0.0, 0.0, 0.0, 0.0))) == pytest.approx(0.0, abs=1e-9)


@MODERATE
@given(vectors(4, 2.0), st.floats(-3.0, 3.0))
def test_the_regressor_with_the_true_constants_is_the_plant(nu, heading):
    """Y a = M nu' + C nu + D nu for the nu' that the plant really has under a wrench."""
    plant, tau = Model(Plant(**NOMINAL)), (30.0, -20.0, 10.0, 0.0, 0.0, 5.0)
    rate = plant.derivative(
        (0.0, 0.0, 0.0, *quaternion_from_heading(heading), *nu[:3], 0.0, 0.0, nu[3]), tau, STILL_WATER
    )
    forces = body_forces(TRUE, nu, nu, (rate[7], rate[8], rate[9], rate[12]))
    assert forces == pytest.approx((30.0, -20.0, 10.0, 5.0), abs=1e-9)


def _v_and_slopes(law, plant, state, view, path_at, step_s=1e-5):
    """Return V at `view` and its two candidates' central difference along plant and law together."""
    start = (*view.nav.position, *view.nav.attitude, *view.nav.nu)
    tau, rates = law.evaluate(state, view)
    slope = plant.derivative(start, tau, STILL_WATER)

    def value(step):
        x = tuple(a + step * b for a, b in zip(start, slope, strict=True))
        later = tuple(a + step * b for a, b in zip(state, rates, strict=True))
        nav = VehicleState(0, x[:3], x[3:7], x[7:])
        t_s = view.t_s + step
        return np.array(law.lyapunov(later, MotionView(t_s, nav, path_at(step)), plant.kinetic_energy))

    return value(0.0), (value(step_s) - value(-step_s)) / (2.0 * step_s)


def _moving(path):
    """Return the path point a small time on, exact to second order."""

    def at(step):
        return PathPoint(
            tuple(p + step * v for p, v in zip(path.position, path.velocity, strict=True)),
            tuple(v + step * a for v, a in zip(path.velocity, path.acceleration, strict=True)),
            path.acceleration,
            path.heading_rad + step * path.heading_rate_radps,
            path.heading_rate_radps + step * path.heading_acceleration_radps2,
            path.heading_acceleration_radps2,
        )

    return at


@MODERATE
@given(views(), st.lists(st.floats(0.2, 3.0), min_size=12, max_size=12))
def test_v_falls_as_the_proof_says(view, ratios):
    """V' = -s^T (K_D + D(nu)) s, exactly, for any estimates, thesis (3.36) with the damping kept."""
    law = Controller(Params(blend_s=0.0), 0.05)
    plant = Model(Plant(**NOMINAL))
    state = tuple(ratio * value + 0.1 for ratio, value in zip(ratios, TRUE, strict=True))
    value, slope = _v_and_slopes(law, plant, state, view, _moving(view.path))
    # s, worked here with J as a complex factor
    nav, path = view.nav, view.path
    psi = 2.0 * math.atan2(nav.attitude[3], nav.attitude[0])
    error = np.subtract(nav.position, path.position)
    yaw = math.remainder(psi - path.heading_rad, 2.0 * math.pi)
    wanted = np.subtract(path.velocity, 0.5 * error)
    planar = complex(wanted[0], wanted[1]) * complex(math.cos(psi), -math.sin(psi))
    nu = np.array([*nav.nu[:3], nav.nu[5]])
    s = nu - [planar.real, planar.imag, wanted[2], path.heading_rate_radps - 0.5 * yaw]
    damping = np.array(NOMINAL["linear_damping"]) + np.array(NOMINAL["quadratic_damping"]) * np.abs(nu)
    expected = -np.dot(s, (np.array(law.params.error_gain) + damping) * s)
    assert slope[1] == pytest.approx(expected, rel=1e-5, abs=1e-5 * (1.0 + value[1]))
    assert expected <= 0.0


def test_the_printed_candidate_rises_where_the_corrected_one_falls():
    """(3.21) knows eight of the twelve parameters, and M does not commute with J."""
    law, plant = Controller(Params(blend_s=0.0, initial_ratio=0.7), 0.05), Model(Plant(**NOMINAL))
    path = PathPoint((0.0, 0.0, 0.0), (1.0, 0.5, 0.2), (0.1, 0.1, 0.1), 1.0, 0.2, 0.1)
    along = complex(*path.velocity[:2]) * complex(math.cos(1.0), -math.sin(1.0))
    rng, rises = np.random.default_rng(3), 0
    for _ in range(100):
        x, y, z, u, v, w, turn, r = rng.uniform(-0.001, 0.001, 8)
        nu = (along.real + u, along.imag + v, 0.2 + w, 0.0, 0.0, 0.2 + r)
        view = MotionView(0.0, VehicleState(0, (x, y, z), quaternion_from_heading(1.0 + turn), nu), path)
        _, slope = _v_and_slopes(law, plant, law.initial_state(view), view, _moving(path))
        assert slope[1] <= 1e-6
        rises += slope[0] > 1e-5
    assert rises > 10


@MODERATE
@given(st.lists(st.floats(-500.0, 2000.0), min_size=12, max_size=12))
def test_the_box_holds_the_estimates_and_only_brings_them_nearer(estimates):
    """A box that has the truth in it never makes a~^T GAM^-1 a~ larger."""
    law = Controller(Params(blend_s=0.0), 0.05)
    held = np.array(law.constrained(tuple(estimates)))
    nominal = np.array(TRUE)
    assert np.all(held >= 0.2 * nominal)
    assert np.all(held <= 3.0 * nominal + 20.0)
    assert np.all(np.abs(held - nominal) <= np.abs(estimates - nominal))
    inside = (np.array(estimates) >= 0.2 * nominal) & (np.array(estimates) <= 3.0 * nominal + 20.0)
    np.testing.assert_array_equal(held[inside], np.array(estimates)[inside])


def test_without_the_box_estimates_go_where_they_like():
    assert Controller(Params(box=False), 0.05).constrained((-1e6,) * 17) == (-1e6,) * 17


def test_the_box_leaves_the_start_of_the_blend_alone():
    law = Controller(Params(), 0.05)
    start = (3.0, -40.0, 50.0, -60.0, 1.0)
    assert law.constrained((*TRUE, *start)) == (*TRUE, *start)


def test_first_estimates_outside_the_box_begin_at_its_edge():
    view = flat_view((0.0,) * 4, (0.0,) * 4)
    boxed = Controller(Params(initial_ratio=0.0, blend_s=0.0), 0.05).initial_state(view)
    np.testing.assert_allclose(boxed, 0.2 * np.array(TRUE))
    free = Controller(Params(initial_ratio=0.0, blend_s=0.0, box=False), 0.05).initial_state(view)
    assert free == (0.0,) * 12


# --- around both -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["adaptive_thesis", "adaptive_thesis_grouped_gamma", "adaptive_corrected"])
@MODERATE
@given(view=views())
def test_a_blended_start_begins_without_an_error(name, view):
    """At the first instant e = 0, so only the motion, not the place, asks for a force."""
    law = Controller(replace(preset(name).params, blend_s=40.0), 0.05)
    here = replace(view, path=view.path._replace(position=view.nav.position))
    there = replace(here, path=here.path._replace(position=(100.0, -50.0, 20.0)))
    for other in (here, there):
        assert law.initial_state(other)[-5] == view.t_s
    np.testing.assert_allclose(
        law.evaluate(law.initial_state(there), there)[0],
        law.evaluate(law.initial_state(here), here)[0],
        atol=1e-6,
    )


def test_the_estimates_stand_still_while_the_force_limit_holds():
    limited = Controller(Params(blend_s=0.0, max_force_n=40.0, max_moment_nm=5.0), 0.05)
    far = flat_view((5.0, -0.01, 0.0, 1.0), (0.0,) * 4)
    tau, rate = limited.evaluate(limited.initial_state(far), far)
    assert (abs(tau[0]), abs(tau[5])) == (40.0, 5.0)
    assert abs(tau[2]) < 40.0
    assert rate == (0.0,) * 12
    near = flat_view((0.001,) * 4, (0.0,) * 4, velocity=(0.01, 0.0, 0.0), acceleration=STILL_WATER)
    assert any(limited.evaluate(limited.initial_state(near), near)[1])


def test_leakage_draws_back_to_the_first_estimates():
    """With no error left, a^' = -sigma GAM (a^ - a^(0))."""
    law = Controller(Params(blend_s=0.0, initial_ratio=0.7, leakage_ps=1e-3), 0.05)
    view = flat_view((0.0,) * 4, (0.0,) * 4)
    view = replace(view, path=view.path._replace(velocity=(0.0, 0.0, 0.0), heading_rate_radps=0.0))
    view = replace(view, nav=view.nav._replace(nu=(0.0,) * 6))
    first = np.array(law.initial_state(view))
    np.testing.assert_allclose(law.evaluate(tuple(first), view)[1], 0.0, atol=1e-15)
    gains = np.array([100, 100, 100, 30, 100, 100, 100, 10, 400, 600, 400, 10])
    away = np.arange(12.0)
    np.testing.assert_allclose(law.evaluate(tuple(first + away), view)[1], -1e-3 * gains * away, atol=1e-12)


@pytest.mark.parametrize("name", ["adaptive_thesis", "adaptive_corrected"])
@MODERATE
@given(view=views(), turns=st.integers(-3, 3))
def test_whole_turns_of_the_reference_do_not_matter(name, view, turns):
    law = preset(name)
    turned = replace(view, path=view.path._replace(heading_rad=view.path.heading_rad + 2.0 * math.pi * turns))
    gap = math.remainder(
        2.0 * math.atan2(view.nav.attitude[3], view.nav.attitude[0]) - view.path.heading_rad, 2 * math.pi
    )
    if abs(gap) > 3.14:
        return
    one, other = (law.evaluate(law.initial_state(v), v)[0] for v in (view, turned))
    np.testing.assert_allclose(one, other, rtol=1e-7, atol=1e-6)


def test_names_fit_the_state():
    view = flat_view((0.0,) * 4, (0.0,) * 4)
    for name, count in (("adaptive_thesis", 8), ("adaptive_corrected", 12)):
        law = preset(name)
        assert len(law.params.names) == count
        start = 5 if law.params.blend_s else 0
        assert len(law.initial_state(view)) == count + start
        assert len(law.evaluate(law.initial_state(view), view)[1]) == count + start
    assert preset("adaptive_corrected").params.names[:2] == ("m11", "m22")
    assert preset("adaptive_thesis").params.names[:2] == ("m11", "dQ1")


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"mode": "corrected", "frame": "flat"}, "frame: 'flat' is not allowed"),
        ({"mode": "thesis", "frame": "flat"}, "linear_adaptation: "),
        ({"error_gain": [1, 2, 3]}, "error_gain: "),
        ({"error_gain": [1, 0, 3, 4]}, r"error_gain\[1\]: 0.0 is not allowed"),
        ({"error_rate_ps": [1, -1, 1, 1]}, r"error_rate_ps\[1\]: "),
        ({"inertia_adaptation": [1, -1, 1, 1]}, r"inertia_adaptation\[1\]: "),
        ({"nominal_inertia": [0, 1, 1, 1]}, r"nominal_inertia\[0\]: "),
        ({"high_ratio": 0.5}, "high_ratio: "),
    ],
)
def test_what_cannot_work_is_refused(changed, message):
    with pytest.raises(ValueError, match=message):
        load(Params, changed, "params")


def test_a_view_without_a_path_is_refused():
    view = replace(flat_view((0.0,) * 4, (0.0,) * 4), path=None)
    with pytest.raises(ValueError, match="view without a path"):
        Controller(Params(), 0.05).initial_state(view)
