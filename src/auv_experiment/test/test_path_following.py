"""
The scenarios of thesis chapter 2 against numbers found once with an independent integration.

That integration (an adaptive Runge-Kutta 4(5), relative tolerance 1e-9) was written from the equations
alone and shares no code with this project. The thesis's own readings (its Table 2.2 and Fig. 2.18) are named
as such. Runs of 600 s here take steps of 0.1 s, which give the same five digits as 0.02 s.
"""

import math
from typing import Any

import numpy as np
import pytest

from auv_core.params import ConfigError
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.lyapunov import lyapunov_metrics
from auv_experiment.metrics.path import heading_rad, path_metrics, position_error_ned_m
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.scenario.loading import load_scenario
from auv_sim.vehicle import DivergedError

LAW = "agent.controller.params"
PLANT = "vehicles.0.model.params"
SIXTY = f"vehicles.0.heading_rad={math.pi / 3.0}"
DAMPED = {"pfpd": (f"{PLANT}.drag=abs",), "pfapd": (f"{PLANT}.drag=abs", f"{LAW}.drag=abs")}
CASES: dict[str, Any] = {
    "flat, thesis drag": ("ch2_{}", {"pfpd": (), "pfapd": ()}),
    "flat, |a| drag": ("ch2_{}", DAMPED),
    "body": ("ch2_{}_corrected", {"pfpd": (), "pfapd": ()}),
    "body from 60 degrees": ("ch2_{}_corrected", {"pfpd": (SIXTY,), "pfapd": (SIXTY,)}),
}
WITH_OBSTACLES = {"ch2_{}": "ch2_{}_obstacles", "ch2_{}_corrected": "ch2_{}_obstacles_corrected"}


class _Flown:
    def __init__(self, name, overrides, duration_s):
        self.scenario = load_scenario(name, overrides=overrides, duration_s=duration_s)
        self.recording = run_in_process(self.scenario)
        self.metrics = path_metrics(self.recording, self.scenario)
        self.error_m = position_error_ned_m(self.recording, self.scenario)[:, 0]

    def at(self, axis, t_s):
        return self.error_m[round(t_s / self.scenario.period_s), axis]

    def rms_after_100s_m(self):
        late = self.error_m[self.recording.t_s >= 100.0]
        return math.sqrt((late**2).sum(axis=1).mean())


@pytest.fixture(scope="module")
def fly():
    """Fly a scenario; the same one is flown once."""
    flown = {}

    def flight(name, *overrides, dt_s=0.1, duration_s=600.0):
        key = (name, overrides, dt_s, duration_s)
        if key not in flown:
            flown[key] = _Flown(name, ["readings=[]", f"dt_s={dt_s}", *overrides], duration_s)
        return flown[key]

    return flight


@pytest.fixture(scope="module")
def fly_case(fly):
    def flight(case, kind, *, obstacles=False, extra=()):
        pattern, overrides = CASES[case]
        pattern = WITH_OBSTACLES[pattern] if obstacles else pattern
        return fly(pattern.format(kind), *overrides[kind], *extra)

    return flight


# --- Table 2.2 -------------------------------------------------------------------------------------------


def _readings(name, *overrides):
    scenario = load_scenario(name, overrides=overrides, duration_s=33.0)
    return compute_metrics(run_in_process(scenario), scenario, mode="inprocess", real_time_factor=1.0)


def test_table_2_2_pd_row_to_every_printed_digit():
    metrics = _readings("ch2_pfpd")
    assert metrics["x_err_5p4_m"] == pytest.approx(0.31614, abs=2e-5)
    # The readings of thesis Fig. 2.18; Table 2.2 misprints the first as 0.03161.
    assert f"{metrics['x_err_5p4_m']:.4f}" == "0.3161"
    assert f"{metrics['x_err_18p3_m']:.3f}" == "0.084"
    assert f"{metrics['y_err_32p9_m']:.4f}" == "-0.0202"
    assert metrics["x_err_18p3_m"] == pytest.approx(0.08400, abs=2e-5)
    assert metrics["y_err_32p9_m"] == pytest.approx(-0.02019, abs=2e-5)


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        ((f"{LAW}.velocity_gain=[40.0, 50.0, 0.0]",), (0.3170, 0.0856, -0.0204)),
        ((f"{PLANT}.drag=abs",), (0.3042, 0.0832, -0.0232)),
    ],
    ids=["printed gains", "|a| drag"],
)
def test_other_gains_or_drag_miss_the_pd_row(overrides, expected):
    metrics = _readings("ch2_pfpd", *overrides)
    found = [metrics[key] for key in ("x_err_5p4_m", "x_err_18p3_m", "y_err_32p9_m")]
    assert found == pytest.approx(expected, abs=1e-4)
    assert abs(found[0] - 0.3161) > 5e-4
    assert abs(found[2] + 0.0202) > 1.5e-4


def test_table_2_2_apd_row_is_not_the_thesis_s():
    metrics = _readings("ch2_pfapd")
    assert metrics["x_err_5p8_m"] == pytest.approx(0.2750, abs=5e-4)
    assert metrics["x_err_18p6_m"] == pytest.approx(0.0072, abs=3e-4)
    assert metrics["y_err_32p8_m"] == pytest.approx(0.00065, abs=2e-4)


def test_the_initial_error_is_what_the_table_calls_the_overshoot_in_y(fly_case):
    for kind in ("pfpd", "pfapd"):
        assert fly_case("flat, thesis drag", kind).at(1, 0.0) == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("kind", "x_s", "y_wide_s", "y_s", "velocity_s", "peak_mps"),
    [("pfpd", 10.5, 10.5, 11.5, 21.3, 2.186), ("pfapd", 9.2, 10.3, 11.3, 21.1, 2.185)],
)
def test_settling_as_the_thesis_ran_it(fly_case, kind, x_s, y_wide_s, y_s, velocity_s, peak_mps):
    metrics = fly_case("flat, thesis drag", kind).metrics
    assert metrics["x_settling_0p1m_s"] == pytest.approx(x_s, abs=0.3)
    assert metrics["y_settling_0p2m_s"] == pytest.approx(y_wide_s, abs=0.3)
    assert metrics["y_settling_0p1m_s"] == pytest.approx(y_s, abs=0.3)
    assert metrics["velocity_settling_0p01mps_s"] == pytest.approx(velocity_s, abs=0.5)
    assert metrics["velocity_err_y_peak_mps"] == pytest.approx(peak_mps, abs=1e-3)


# --- PD against augmented PD -----------------------------------------------------------------------------

# overshoot x, undershoot y, rms, rms after 30 s, largest |x_e| and |y_e| after 100 s (all m), effort (N^2 s)
COMPARED = {
    ("flat, thesis drag", "pfpd"): (0.3172, -0.2452, 0.5804, 0.0682, 0.077, 0.080, 3.950e6),
    ("flat, thesis drag", "pfapd"): (0.2780, -0.2261, 0.5764, 0.0001, 0.0, 0.0, 3.940e6),
    ("flat, |a| drag", "pfpd"): (0.3042, -0.2417, 0.5815, 0.0783, 0.080, 0.080, 3.964e6),
    ("flat, |a| drag", "pfapd"): (0.2622, -0.2245, 0.5763, 0.0, 0.0, 0.0, 3.954e6),
    ("body", "pfpd"): (0.2229, -0.2217, 0.5813, 0.0784, 0.078, 0.080, 3.965e6),
    ("body", "pfapd"): (0.1746, -0.2165, 0.5759, 0.0, 0.0, 0.0, 3.966e6),
    ("body from 60 degrees", "pfpd"): (0.4661, -0.2191, 0.5746, 0.0784, 0.078, 0.080, 2.884e6),
    ("body from 60 degrees", "pfapd"): (0.3691, -0.2133, 0.5688, 0.0, 0.0, 0.0, 2.852e6),
}


@pytest.mark.parametrize(("case", "kind"), COMPARED)
def test_errors_and_effort(fly_case, case, kind):
    flight = fly_case(case, kind)
    over, under, rms, late_rms, late_x, late_y, effort = COMPARED[case, kind]
    metrics = flight.metrics
    assert metrics["overshoot_x_m"] == pytest.approx(over, rel=0.01)
    assert metrics["undershoot_y_m"] == pytest.approx(under, rel=0.01)
    assert metrics["position_rms_m"] == pytest.approx(rms, rel=0.01)
    assert metrics["position_rms_after_30s_m"] == pytest.approx(late_rms, rel=0.01, abs=1e-3)
    late = np.abs(flight.error_m[flight.recording.t_s >= 100.0]).max(axis=0)
    assert late[:2] == pytest.approx((late_x, late_y), rel=0.01, abs=1e-3)
    assert metrics["control_effort_n2s"] == pytest.approx(effort, rel=0.01)


@pytest.mark.parametrize("case", CASES)
def test_the_augmented_law_removes_the_steady_error_and_cuts_the_overshoot(fly_case, case):
    plain, augmented = (fly_case(case, kind).metrics for kind in ("pfpd", "pfapd"))
    assert augmented["position_rms_after_30s_m"] < 1e-4 < 0.06 < plain["position_rms_after_30s_m"]
    assert 0.12 < 1.0 - augmented["overshoot_x_m"] / plain["overshoot_x_m"] < 0.22
    assert 1.0 - augmented["position_rms_m"] / plain["position_rms_m"] < 0.011


def test_the_steady_error_of_pd_is_drag_over_gain(fly_case):
    """At 0.1 m/s the drag is 8 N along and 12 N across: 0.08 m with 100 and with 150 N/m."""
    late = np.abs(fly_case("flat, |a| drag", "pfpd").error_m)[1000:].max(axis=0)
    assert late[0] == pytest.approx((70.0 + 100.0 * 0.1) * 0.1 / 100.0, rel=0.01)
    assert late[1] == pytest.approx((100.0 + 200.0 * 0.1) * 0.1 / 150.0, rel=0.01)


@pytest.mark.parametrize("kind", ["pfpd", "pfapd"])
def test_nothing_steers(fly_case, kind):
    """Yaw turns as the water and the coupling make it, not towards the reference of 60 degrees."""
    flight = fly_case("flat, thesis drag", kind)
    headings = heading_rad(flight.recording)[:, 0]
    assert headings.max() <= 1e-9
    assert headings.min() == pytest.approx({"pfpd": -0.58, "pfapd": -0.684}[kind], abs=0.01)
    assert not flight.recording.command[:, 0, 2:].any()


# --- obstacles -------------------------------------------------------------------------------------------

# closest (m) and when (s) for both obstacles, worst error after 30 s (m), rms after 30 s (m), settling (s)
PASSED = {
    ("flat, thesis drag", "pfpd"): (0.711, 100.7, 0.605, 421.0, 0.388, 0.0821, 21.3, 11.6),
    ("flat, thesis drag", "pfapd"): (0.717, 100.1, 0.607, 420.1, 0.350, 0.0441, 21.1, 11.4),
    ("flat, |a| drag", "pfpd"): (0.716, 100.8, 0.605, 420.9, 0.389, 0.0910, 17.9, 11.7),
    ("flat, |a| drag", "pfapd"): (0.717, 100.0, 0.607, 420.1, 0.350, 0.0441, 17.8, 11.4),
    ("body", "pfpd"): (0.719, 100.7, 0.579, 421.9, 0.407, 0.0920, 17.9, 11.8),
    ("body", "pfapd"): (0.717, 100.0, 0.578, 421.1, 0.354, 0.0450, 17.8, 11.3),
}


def _clearance(metrics, expected_m):
    assert metrics["obstacle_clearance_m"] == pytest.approx(expected_m, abs=0.002)


@pytest.mark.parametrize(("case", "kind"), PASSED)
def test_obstacles_are_passed(fly_case, case, kind):
    first_m, first_s, second_m, second_s, worst_m, rms_m, velocity_s, position_s = PASSED[case, kind]
    metrics = fly_case(case, kind, obstacles=True).metrics
    _clearance(metrics, (first_m, second_m))
    assert metrics["obstacle_closest_at_s"] == pytest.approx((first_s, second_s), abs=0.3)
    assert metrics["position_err_max_m"] == pytest.approx(worst_m, abs=0.01)
    assert metrics["position_rms_after_30s_m"] == pytest.approx(rms_m, rel=0.01)
    assert metrics["velocity_settling_0p01mps_s"] == pytest.approx(velocity_s, abs=0.3)
    assert metrics["position_settling_0p1m_s"] == pytest.approx(position_s, abs=0.3)


ROCKS = "environment.obstacles"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "expected_m"),
    [
        ((f"{ROCKS}.0.safety_distance_m=1.0", f"{ROCKS}.1.safety_distance_m=1.0"), (0.602, 0.448)),
        ((f"{ROCKS}.0.safety_distance_m=3.0", f"{ROCKS}.1.safety_distance_m=3.0"), (0.807, 0.721)),
        ((f"{LAW}.obstacle_gain_nm=10.0",), (1.003, 0.961)),
    ],
    ids=["d = 1 m", "d = 3 m", "tenfold gain"],
)
def test_clearance_grows_with_distance_and_gain(fly_case, changes, expected_m):
    flight = fly_case("flat, thesis drag", "pfpd", obstacles=True, extra=changes)
    _clearance(flight.metrics, expected_m)
    if "gain" in changes[0]:
        assert flight.metrics["position_err_max_m"] == pytest.approx(0.757, abs=0.01)


@pytest.mark.slow
def test_the_other_reading_of_the_second_obstacle(fly_case):
    """The thesis's text has lost its minus signs: [-9, 5, 0] is possible and gives about the same."""
    moved = (f"{ROCKS}.1.position_ned_m=[-9.0, 5.0, 0.0]",)
    metrics = fly_case("flat, thesis drag", "pfpd", obstacles=True, extra=moved).metrics
    assert metrics["obstacle_clearance_m"][1] == pytest.approx(0.568, abs=0.002)
    assert metrics["obstacle_closest_at_s"][1] == pytest.approx(521.6, abs=0.3)


# --- what the law knows of the vehicle -------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(("scale", "rms_m"), [(0.8, 0.0156), (1.2, 0.0156), (0.5, 0.0391), (1.5, 0.0391)])
def test_the_augmented_law_is_as_good_as_its_damping(fly_case, scale, rms_m):
    metrics = fly_case("flat, |a| drag", "pfapd", extra=(f"{LAW}.damping_scale={scale}",)).metrics
    assert metrics["position_rms_after_30s_m"] == pytest.approx(rms_m, rel=0.01)


# --- frames mixed, as the thesis prints it ---------------------------------------------------------------


def _mixed(fly, kind, start_rad, duration_s=600.0):
    return fly(
        f"ch2_{kind}_corrected",
        f"{LAW}.frame=mixed",
        f"vehicles.0.heading_rad={start_rad}",
        duration_s=duration_s,
    )


@pytest.mark.parametrize("kind", ["pfpd", "pfapd"])
def test_mixed_frames_never_come_to_the_path_from_60_degrees(fly, kind):
    flight = _mixed(fly, kind, math.pi / 3.0, duration_s=200.0)
    assert flight.metrics["position_settling_0p1m_s"] is None
    assert flight.rms_after_100s_m() > 0.85


@pytest.mark.slow
@pytest.mark.parametrize(
    ("start_rad", "plain_m", "augmented_m"),
    [
        (0.0, 0.082, 0.042),
        (0.3, 0.51, 0.48),
        (0.6, 0.92, 0.90),
        (1.0, 0.92, 0.90),
        (math.pi / 3.0, 0.92, 0.90),
    ],
)
def test_mixed_frames_are_usable_only_near_north(fly, start_rad, plain_m, augmented_m):
    found = [_mixed(fly, kind, start_rad).rms_after_100s_m() for kind in ("pfpd", "pfapd")]
    assert found == pytest.approx([plain_m, augmented_m], rel=0.02)


# --- drag as printed -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("start_m", "end_s"), [(11.5, 3.6), (12.0, 2.5), (15.0, 1.3), (20.0, 0.84)])
def test_printed_drag_blows_up_from_farther_out(start_m, end_s):
    """Faster than 0.5 m/s west, 100 v + 200 v^2 drives the vehicle on."""
    start = (f"vehicles.0.position_ned_m=[0.0, {start_m}, 0.0]", "readings=[]", "dt_s=0.005", "period_s=0.01")
    with pytest.raises(DivergedError) as diverged:
        run_in_process(load_scenario("ch2_pfpd", overrides=start, duration_s=5.0))
    told_s = float(str(diverged.value).split("t = ")[1].split(" s")[0])
    assert told_s == pytest.approx(end_s, abs=0.06)


@pytest.mark.parametrize("start_m", [15.0, 20.0])
def test_real_drag_stays_bounded_from_there(fly, start_m):
    flight = fly(
        "ch2_pfpd",
        f"{PLANT}.drag=abs",
        f"vehicles.0.position_ned_m=[0.0, {start_m}, 0.0]",
        duration_s=60.0,
    )
    assert np.abs(flight.error_m).max() <= start_m - 10.0 + 1e-9
    assert flight.metrics["position_settling_0p1m_s"] < 20.0


# --- Lyapunov --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", ["flat, thesis drag", "body"])
def test_energy_of_the_augmented_law_falls_without_obstacles(fly_case, case):
    flight = fly_case(case, "pfapd")
    metrics = lyapunov_metrics(flight.recording, flight.scenario)
    assert metrics["lyapunov_thesis_falls"]
    assert metrics["lyapunov_corrected_falls"]
    assert "lyapunov_proof_gap" not in metrics


@pytest.mark.parametrize(("kind", "obstacles"), [("pfpd", False), ("pfapd", True)])
def test_energy_rises_where_the_printed_proof_has_a_gap(fly_case, kind, obstacles):
    flight = fly_case("body", kind, obstacles=obstacles)
    metrics = lyapunov_metrics(flight.recording, flight.scenario)
    for name in ("thesis", "corrected"):
        assert not metrics[f"lyapunov_{name}_falls"]
        assert 13.0 < metrics[f"lyapunov_{name}_first_rise_s"] < 90.0
        assert 1e-8 < metrics[f"lyapunov_{name}_largest_rise_ratio"] < 1e-4
    assert "V" in metrics["lyapunov_proof_gap"] or "K_p" in metrics["lyapunov_proof_gap"]


# --- bad input -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (f"{LAW}.frame=body", "frame"),
        (f"{PLANT}.frame=body", "frame"),
        (f"{LAW}.velocity_gain=[50.0, 40.0]", "velocity_gain"),
        ("reference=", "reference"),
    ],
)
def test_a_scenario_that_does_not_fit_is_refused_in_one_line(change, told):
    with pytest.raises(ConfigError) as refused:
        load_scenario("ch2_pfpd", overrides=[change])
    assert told in str(refused.value)
    assert "\n" not in str(refused.value)
