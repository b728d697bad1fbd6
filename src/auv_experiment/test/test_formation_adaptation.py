"""
Whether adaptation helps, in the law of thesis chapter 3 as printed and as corrected.

Numbers as in test_formation: rms of |e_xyz| once things have settled, from the origin. Runs of the corrected
law take steps of 0.2 s, which give the same digits as 0.02 s. Long tables are marked slow; one row of them
always flies.
"""

from typing import Any

import numpy as np
import pytest
from formation_flights import FIXED, GROUPED, PD, alone, fly, law

from auv_control.controllers import MotionView
from auv_control.controllers.adaptive import Controller
from auv_core.geometry import distance, ned_to_body
from auv_core.integrate import rk4_step
from auv_core.messages import VehicleState
from auv_core.models.four_dof import Model
from auv_experiment.metrics.lyapunov import lyapunov_metrics
from auv_experiment.scenario import checks as scenario_checks
from auv_experiment.scenario.loading import load_scenario

NOISE = "environment.navigation={kind: noisy, params: {position_sd_m: 0.05, velocity_sd_mps: 0.05}}"
BODY = "frame: body"

# --- as printed: it hardly does --------------------------------------------------------------------------

PRINTED = {
    "nominal": (1.0, 0.0042, 0.0013, 0.0109, 0.0101, 0.0043),
    "0.7": (0.7, 0.0351, 0.0332, 0.0857, 0.0849, 0.0351),
    "1.3": (1.3, 0.0333, 0.0331, 0.0670, 0.0669, 0.0333),
    "zero": (0.0, 0.1142, 0.1105, 0.2632, 0.2617, 0.1142),
}


def printed(path, words, *changes):
    return fly(f"ch3_{path}", alone(path, radius_m=30.0), law(words), *changes, duration_s=2000.0)


@pytest.mark.slow
@pytest.mark.parametrize("case", PRINTED)
def test_the_printed_adaptation_beats_none_by_little(case):
    ratio, *expected = PRINTED[case]
    start = f"initial_ratio: {ratio}"
    found = [
        printed("circle", f"{start}, {FIXED}").rms_m(1300.0),
        printed("circle", start).rms_m(1300.0),
        printed("spiral", f"{start}, {FIXED}").rms_m(1300.0),
        printed("spiral", start).rms_m(1300.0),
        printed("spiral", start, GROUPED).rms_m(1300.0),
    ]
    assert found == pytest.approx(expected, abs=1.01e-4)


def _largest_late_errors(words, duration_s):
    flight = fly("ch3_circle", alone(radius_m=30.0), law(words), duration_s=duration_s)
    return flight.largest(flight.error(), after_s=0.65 * duration_s)[:2]


def test_y_cannot_be_corrected_and_x_can():
    """On the circle of 30 m from zero: the drag of sway is frozen by a zero of GAM."""
    before, after = (_largest_late_errors(words, 300.0) for words in (PD, "initial_ratio: 0.0"))
    assert after[0] < 0.5 * before[0]
    assert after[1] > 0.9 * before[1]


@pytest.mark.slow
def test_y_cannot_be_corrected_in_half_an_hour_either():
    for words, expected_mm in ((PD, (28.9, 110.0)), ("initial_ratio: 0.0", (0.95, 110.0))):
        flight = printed("circle", words)
        late = flight.error()[flight.t_s >= 1300.0][:, :2]
        assert 1e3 * np.sqrt(np.mean(late**2, axis=0)) == pytest.approx(expected_mm, rel=0.02)


def test_gamma_in_the_other_order_corrects_the_depth_of_the_spiral():
    """78 mm go, with a time constant of about 5 s; in the printed order they stay."""
    flights = [
        fly("ch3_spiral", alone("spiral"), law("initial_ratio: 0.7"), *changes, duration_s=200.0)
        for changes in ((), (GROUPED,))
    ]
    stays, goes = (flight.error()[:, 2] for flight in flights)
    assert stays[-1] == pytest.approx(0.0782, abs=2e-4)
    assert abs(goes[-1]) < 1e-12
    e_folds = np.log(abs(goes[200] / goes[400]))
    assert 10.0 / e_folds == pytest.approx(5.0, abs=1.5)


@pytest.mark.slow
def test_on_the_thesis_own_metric_it_is_worse():
    """max |d12 - d23| for t > 100 s, all three from the origin, each alone."""
    for words, expected_mm in (
        (PD, 13.6),
        ("initial_ratio: 0.0", 20.9),
        (f"{FIXED}, initial_ratio: 0.7", 4.1),
        ("initial_ratio: 0.7", 7.1),
    ):
        flights = [
            fly("ch3_circle", alone(radius_m=radius_m), law(words), duration_s=2000.0)
            for radius_m in (10.0, 20.0, 30.0)
        ]
        first, second, third = (np.hypot(*f.recording.position_ned_m[:, 0, :2].T) for f in flights)
        late = flights[0].t_s > 100.0
        gap_mm = 1e3 * np.abs(2.0 * second - first - third)[late].max()
        assert gap_mm == pytest.approx(expected_mm, abs=0.2)


# --- as corrected: it does -------------------------------------------------------------------------------

CORRECTED = {
    "circle 0.01": (("circle", 30.0, 0.01, "fixed"), (0.2696, 0.0602, 0.0040, 0.0495, 0.0036, 0.0140)),
    "spiral 0.01": (("spiral", 30.0, 0.01, "fixed"), (1.604, 0.3113, 0.0040, 0.2391, 0.0036, 0.0140)),
    "circle 0.05 10 m": (("circle", 10.0, 0.05, "fixed"), (0.7186, 0.1409, 0.0106, 0.1081, 0.0094, 0.0361)),
    "circle 0.05 30 m": (("circle", 30.0, 0.05, "fixed"), (6.34, 0.7596, 0.0113, 0.4903, 0.0095, 0.0344)),
    "tangent": (("circle", 30.0, 0.05, "tangent"), (4.58, 0.7029, 0.0049, 0.4797, 0.0072, 0.0166)),
}
CASES = [
    case if case == "circle 0.05 30 m" else pytest.param(case, marks=pytest.mark.slow) for case in CORRECTED
]


def corrected(where, words, *changes, duration_s=600.0):
    path, radius_m, rate_radps, heading = where
    vehicle = alone(path, radius_m=radius_m, rate_radps=rate_radps, model=BODY, heading=heading)
    return fly(f"ch3_{path}_corrected", vehicle, law(words), *changes, dt_s=0.2, duration_s=duration_s)


@pytest.mark.parametrize("case", CASES)
def test_the_corrected_adaptation_beats_none_by_much(case):
    where, expected = CORRECTED[case]
    pd, fixed_low, low, fixed_high, high, zero = found = [
        corrected(where, words).rms_m(300.0)
        for words in (
            PD,
            f"{FIXED}, initial_ratio: 0.7",
            "box: false, initial_ratio: 0.7",
            f"{FIXED}, initial_ratio: 1.3",
            "box: false, initial_ratio: 1.3",
            "box: false, initial_ratio: 0.0",
        )
    ]
    assert found == pytest.approx(expected, rel=0.02, abs=1e-4)
    assert low <= fixed_low / 5.0
    assert high <= fixed_high / 5.0
    assert zero <= pd / 10.0


@pytest.mark.slow
@pytest.mark.parametrize("case", CORRECTED)
def test_exact_estimates_leave_no_error_and_the_box_does_no_harm(case):
    where, expected = CORRECTED[case]
    assert corrected(where, f"{FIXED}, initial_ratio: 1.0").rms_m(300.0) < 1e-5
    assert corrected(where, "initial_ratio: 0.7").rms_m(300.0) < 1.1 * expected[2]


@pytest.mark.slow
def test_equal_errors_cancel_in_the_difference_of_distances():
    """So |d12 - d23| is no measure of adaptation: it grows, while the errors become many times smaller."""
    late_mm = {}
    for words in (f"{FIXED}, initial_ratio: 1.3", "initial_ratio: 1.3"):
        flights = [corrected(("circle", radius_m, 0.05, "fixed"), words) for radius_m in (10.0, 20.0, 30.0)]
        first, second, third = (np.hypot(*f.recording.position_ned_m[:, 0, :2].T) for f in flights)
        late = flights[0].t_s > 300.0
        late_mm[words] = 1e3 * np.abs(2.0 * second - first - third)[late].max()
    assert list(late_mm.values()) == pytest.approx([10.3, 15.7], abs=0.1)


def test_the_corrected_candidate_falls_along_the_flight_and_the_printed_one_does_not():
    flight = fly("ch3_circle_corrected", dt_s=0.1, duration_s=60.0)
    m = lyapunov_metrics(flight.recording, flight.scenario)
    assert m["lyapunov_corrected_falls"]
    assert m["lyapunov_corrected_largest_rise_ratio"] < 1e-12
    assert not m["lyapunov_thesis_falls"]


# --- force limits ----------------------------------------------------------------------------------------


def test_with_too_little_force_the_vehicle_falls_behind_and_the_estimates_stand_still(monkeypatch):
    """The circle of 30 m at 0.05 rad/s needs 912 N; a scenario with less is refused at load."""
    monkeypatch.setattr(scenario_checks, "check_reach", lambda _: None)
    where = ("circle", 30.0, 0.05, "fixed")
    free = corrected(where, "initial_ratio: 1.0")
    assert free.largest(free.recording.command[:, 0], after_s=300.0).max() == pytest.approx(912.0, abs=1.0)
    weak = corrected(where, "initial_ratio: 1.0, max_force_n: 800.0")
    assert weak.rms_m(300.0) == pytest.approx(0.75, abs=0.06)
    assert weak.metrics["adaptation_frozen_s"] > 200.0
    assert np.abs(weak.recording.command).max() == 800.0


# --- drift without excitation ----------------------------------------------------------------------------

NEAR = ("circle", 10.0, 0.01, "fixed")
DRIFT = {
    "free": "box: false",
    "box": "box: true",
    "leaking": "box: false, leakage_ps: 1.0e-4",
    "fixed": f"{FIXED}, box: false",
}


def noisy(case, duration_s):
    """Fly AUV1 on noisy measurements, sampled at 0.05 s, from 0.7 of the true values."""
    path, radius_m, rate_radps, heading = NEAR
    vehicle = alone(path, radius_m=radius_m, rate_radps=rate_radps, model=BODY, heading=heading)
    changes = ("sampling=sampled", NOISE, vehicle, law(f"initial_ratio: 0.7, {DRIFT[case]}"))
    return fly("ch3_circle_corrected", *changes, dt_s=0.05, duration_s=duration_s)


def test_noise_makes_the_masses_grow_and_leakage_stops_it():
    free, leaking = noisy("free", 300.0), noisy("leaking", 300.0)
    masses = [free.estimate("m11", t_s) for t_s in (100.0, 200.0, 300.0)]
    assert masses[1] - masses[0] == pytest.approx(13.4, abs=4.0)
    assert masses[2] - masses[1] == pytest.approx(13.4, abs=4.0)
    assert leaking.estimate("m11", 300.0) - leaking.estimate("m11", 200.0) < 3.0


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_after_an_hour_of_noise_only_the_box_and_leakage_hold():
    """Without either the masses end five times too large, and the error is larger than the fixed law's."""
    flights = {case: noisy(case, 4000.0) for case in DRIFT}
    assert flights["free"].estimate("m11", 4000.0) > 3.0 * 99.0 + 20.0
    assert flights["free"].rms_m(2000.0) > 1.2 * flights["fixed"].rms_m(2000.0)
    held = flights["box"].recording.law_state[:, 0, :12]
    nominal = np.array([99, 108.5, 126.5, 29.1, 10, 0, 10, 1.603, 227.18, 405.42, 227.18, 12.937])
    assert (held >= 0.2 * nominal - 1e-9).all()
    assert (held <= 3.0 * nominal + 20.0 + 1e-9).all()
    assert flights["leaking"].estimate("m11", 4000.0) == pytest.approx(81.0, abs=4.0)
    assert flights["leaking"].rms_m(2000.0) < flights["fixed"].rms_m(2000.0)


# --- a force that the law does not know ------------------------------------------------------------------


def _pushed(words, duration_s=600.0, dt_s=0.2):
    """Fly AUV1 under 30, 20, 20 N (NED); return its rms error of the second half (m) and its estimates."""
    scenario = load_scenario(
        "ch3_circle_corrected", overrides=[alone(model=BODY), law(f"initial_ratio: 0.7, {words}")]
    )
    plant = Model(scenario.vehicles[0].model.params)
    path: Any = scenario.reference_of(0)
    control = Controller(scenario.agent.controller.params, dt_s)

    def view(t_s, x):
        return MotionView(t_s, VehicleState(0, x[:3], x[3:7], x[7:13]), path.at(t_s))

    def derivative(t_s, x):
        tau, rates = control.evaluate(x[13:], view(t_s, x))
        push = ned_to_body(x[3:7], (30.0, 20.0, 20.0))
        total = (tau[0] + push[0], tau[1] + push[1], tau[2] + push[2], 0.0, 0.0, tau[5])
        return (*plant.derivative(x[:13], total, (0.0, 0.0, 0.0)), *rates)

    x: Any = plant.initial_state((0.0, 0.0, 0.0), 0.0)
    x += control.initial_state(view(0.0, x))
    squares = []
    for step in range(round(duration_s / dt_s)):
        x = rk4_step(derivative, step * dt_s, x, dt_s)
        x = (*plant.normalised(x[:13]), *control.constrained(x[13:]))
        if step * dt_s >= duration_s / 2.0:
            squares.append(distance(x[:3], path.at((step + 1) * dt_s).position) ** 2)
    return np.sqrt(np.mean(squares)), dict(zip(control.params.names, x[13:25], strict=True))


def test_a_constant_force_passes_for_linear_drag():
    """It masquerades as d_L; an offset stays, smaller than the fixed law's, and larger again with the box."""
    fixed_m, _ = _pushed(f"{FIXED}, box: false")
    free_m, free = _pushed("box: false")
    boxed_m, boxed = _pushed("box: true")
    assert [fixed_m, free_m, boxed_m] == pytest.approx([0.355, 0.227, 0.3075], abs=0.003)
    assert free["dL1"] == pytest.approx(332.0, abs=5.0)
    assert boxed["dL1"] == 3.0 * 10.0 + 20.0
