"""Formation metrics against motions made by hand."""

import math

import numpy as np
import pytest

from auv_experiment.metrics.formations.errors import (
    errors,
    formation_metrics,
    rate_errors,
    signed_distances_m,
)
from auv_experiment.recording import Recording
from auv_experiment.scenario.loading import load_scenario

IDS = ("auv_1", "auv_2", "auv_3")


@pytest.fixture(scope="module")
def scenario():
    return load_scenario("ch3_circle", overrides=["period_s=0.5"], duration_s=200.0)


@pytest.fixture
def on_the_paths(scenario):
    """Return a recording of vehicles exactly on their paths, with no forces and nominal estimates."""
    t_s = scenario.tick_times()
    recording = Recording.empty(IDS, t_s)
    for i in range(3):
        points = [scenario.reference_of(i).at(t) for t in t_s]
        recording.position_ned_m[:, i] = [point.position for point in points]
        recording.velocity_body[:, i] = [(*point.velocity, 0.0, 0.0, 0.0) for point in points]
    heading = math.pi / 3.0
    recording.attitude_quat_wxyz[:] = (math.cos(heading / 2.0), 0.0, 0.0, math.sin(heading / 2.0))
    recording.command[:] = 0.0
    recording.law_state = np.tile(np.arange(8.0), (recording.n_ticks, 3, 1))
    return recording


def test_on_the_paths_there_is_no_error(scenario, on_the_paths):
    np.testing.assert_allclose(errors(on_the_paths, scenario), 0.0, atol=1e-12)
    np.testing.assert_allclose(rate_errors(on_the_paths, scenario), 0.0, atol=1e-12)
    d12, d23 = signed_distances_m(on_the_paths)
    np.testing.assert_allclose((d12, d23), 10.0)
    m = formation_metrics(on_the_paths, scenario)
    assert m["y_settling_0p05_s"] == m["d12_settling_0p05_s"] == 0.0
    assert m["d12_minus_d23_final_m"] == pytest.approx(0.0, abs=1e-12)
    assert m["d23_true_range_m"] == pytest.approx([10.0, 10.0])
    assert m["estimate_names"] == ["m11", "dQ1", "m22", "dQ2", "m33", "dQ3", "m44", "dQ4"]
    assert m["estimates_final"][2] == list(range(8))
    assert m["adaptation_frozen_s"] == 0.0


def test_an_error_is_path_minus_actual(scenario, on_the_paths):
    on_the_paths.position_ned_m[:, 0, 1] += 0.3
    on_the_paths.velocity_body[:, 0, 2] -= 0.2
    assert errors(on_the_paths, scenario)[7] == pytest.approx([0.0, -0.3, 0.0, 0.0])
    assert rate_errors(on_the_paths, scenario)[7] == pytest.approx([0.0, 0.0, 0.2, 0.0])
    m = formation_metrics(on_the_paths, scenario)
    assert m["position_err_range_m"] == pytest.approx([-0.3, 0.0])
    assert m["velocity_err_range_mps"] == pytest.approx([0.0, 0.2])
    assert m["y_settling_0p05_s"] is None


def test_settling_is_the_first_time_after_the_last_exceedance(scenario, on_the_paths):
    on_the_paths.position_ned_m[:10, 0, 2] -= 1.0
    on_the_paths.position_ned_m[10:20, 0, 2] += 0.2
    on_the_paths.position_ned_m[20:, 0, 2] += 0.04
    m = formation_metrics(on_the_paths, scenario)
    assert m["z_settling_0p05_s"] == 10.0
    assert m["z_overshoot_m"] == pytest.approx(0.2)


def test_yaw_errors_are_wrapped(scenario, on_the_paths):
    heading = math.pi / 3.0 + math.radians(350.0)
    on_the_paths.attitude_quat_wxyz[:] = (math.cos(heading / 2.0), 0.0, 0.0, math.sin(heading / 2.0))
    assert math.degrees(errors(on_the_paths, scenario)[0, 3]) == pytest.approx(10.0)


def test_distances_are_signed_and_true_ones_are_not(scenario, on_the_paths):
    on_the_paths.position_ned_m[0, 0] = (-13.0, 0.0, 10.0)
    on_the_paths.position_ned_m[0, 1] = (0.0, 10.0, 10.0)
    m = formation_metrics(on_the_paths, scenario)
    assert m["d12_range_m"][0] == pytest.approx(-3.0)
    assert m["d12_true_range_m"][1] == pytest.approx(math.hypot(13.0, 10.0))


def test_time_at_the_force_limit_counts_every_vehicle(on_the_paths):
    limited = load_scenario(
        "ch3_circle",
        overrides=["period_s=0.5", "agent.controller.params={max_force_n: 50.0}"],
        duration_s=200.0,
    )
    on_the_paths.command[:4, 0, 1] = -50.0
    on_the_paths.command[2:4, 2, 0] = 50.0
    assert formation_metrics(on_the_paths, limited)["adaptation_frozen_s"] == pytest.approx(3.0)


def test_other_laws_have_no_such_metrics():
    scenario = load_scenario("ch2_pfpd", duration_s=1.0)
    recording = Recording.empty([vehicle.id for vehicle in scenario.vehicles], scenario.tick_times())
    assert formation_metrics(recording, scenario) == {}
