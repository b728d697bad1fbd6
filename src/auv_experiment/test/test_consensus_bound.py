"""Claims about the bound on the consensus error and about the flock's potential along runs."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.consensus_bound import (
    bound_m2ps,
    consensus_series,
    flock_metrics,
    potential_series,
)
from auv_experiment.scenario.loading import load_scenario

AT_REST = "reference.params.rate_radps=0.0"
COARSE = ("dt_s=0.02", "period_s=0.1")


@cache
def _run(name, duration_s, *overrides):
    scenario = load_scenario(name, overrides=overrides, duration_s=duration_s)
    return run_in_process(scenario), scenario


def _metrics(name, duration_s, *overrides):
    return flock_metrics(*_run(name, duration_s, *overrides))


@pytest.mark.parametrize("name", ["ch5_four_leaders", "ch5_one_leader_blind"])
def test_the_bound_of_eq_6_18_holds_without_delays(name):
    metrics = _metrics(name, 30.0, *COARSE)
    assert metrics["consensus_bound_holds"] is True
    assert metrics["consensus_bound_margin_m2ps"] > 0.0
    assert metrics["consensus_error_norm_settled_m"] is None, "this run ends before it settles"


def test_the_recorded_rates_are_those_of_the_error_equation():
    """V_dot = e (-(L + I) e + phi), with L = n I - 1 1^T of a complete graph: nothing is left over."""
    recording, _ = _run("ch5_four_leaders", 30.0, *COARSE)
    positions, centres = recording.position_ned_m[:-1], recording.centre_ned_m
    mean = positions.mean(axis=1, keepdims=True)
    error = centres - mean
    mean_rate = recording.velocity_body[:-1, :, :3].mean(axis=1, keepdims=True)
    phi = positions - mean - mean_rate
    fall = (error * (-5.0 * error + error.sum(axis=1, keepdims=True) + phi)).sum(axis=(1, 2))
    np.testing.assert_allclose(
        consensus_series(recording, 1.0)["fall_m2ps"], fall, atol=1e-9 * np.abs(fall).max()
    )


def test_the_error_is_bounded_and_does_not_vanish():
    metrics = _metrics("ch5_four_leaders", 120.0, *COARSE)
    assert 0.3 < metrics["consensus_error_norm_settled_m"] < metrics["consensus_bound_radius_settled_m"]
    assert metrics["consensus_rho_settled_mps"] < metrics["consensus_rho_mps"]


def test_an_estimate_that_runs_away_breaks_the_bound():
    recording, scenario = _run("ch5_four_leaders", 30.0, *COARSE)
    away = recording.centre_velocity_ned_mps + 500.0 * (
        recording.centre_ned_m - recording.position_ned_m[:-1].mean(axis=1, keepdims=True)
    )
    metrics = flock_metrics(replace(recording, centre_velocity_ned_mps=away), scenario)
    assert metrics["consensus_bound_holds"] is False
    assert metrics["consensus_bound_margin_m2ps"] < 0.0


def test_the_bound_is_the_printed_one():
    np.testing.assert_allclose(bound_m2ps(np.array([0.0, 2.0]), 0.5, 1.0, 4), [0.0, 0.0])
    assert bound_m2ps(np.array([1.0]), 0.5, 3.0, 4)[0] == -1.0


@pytest.mark.parametrize("name", ["ch5_four_leaders", "ch5_one_leader_blind", "ch6_one_leader"])
def test_the_corrected_potential_falls_to_a_path_at_rest(name):
    metrics = _metrics(name, 30.0, AT_REST, "dt_s=0.01", "period_s=0.1")
    assert metrics["flock_lyapunov_corrected_falls"] is True
    assert metrics["flock_lyapunov_corrected_first_rise_s"] is None


def test_the_printed_potential_rises_even_for_a_path_at_rest_where_followers_do_not_know_it():
    metrics = _metrics("ch5_one_leader_blind", 30.0, AT_REST, "dt_s=0.01", "period_s=0.1")
    assert metrics["flock_lyapunov_thesis_falls"] is False
    assert metrics["flock_lyapunov_thesis_first_rise_s"] == 0.0
    assert "(6.45)" in metrics["flock_lyapunov_proof_gap"]


def test_on_the_moving_path_neither_falls_to_the_end():
    metrics = _metrics("ch5_four_leaders", 120.0, *COARSE)
    for name in ("thesis", "corrected"):
        assert metrics[f"flock_lyapunov_{name}_falls"] is False
        assert metrics[f"flock_lyapunov_{name}_first_rise_s"] > 10.0
        assert 0.0 < metrics[f"flock_lyapunov_{name}_largest_rise_ratio"] < 1e-6


def test_obstacles_raise_the_potential():
    recording, scenario = _run("ch5_obstacles", 5.0, *COARSE)
    without = load_scenario("ch5_one_leader", overrides=COARSE, duration_s=5.0)
    moved = replace(recording, position_ned_m=recording.position_ned_m.copy())
    moved.position_ned_m[:, 0] = (8.0, 5.0, 9.0)
    extra = potential_series(moved, scenario)["thesis"] - potential_series(moved, without)["thesis"]
    np.testing.assert_allclose(extra, np.log(0.25) + 3.0)


def test_what_is_not_the_thesiss_law_has_no_such_potential_and_lost_vehicles_no_bound():
    recording, scenario = _run("flock_acoustic", 5.0)
    assert potential_series(recording, scenario) == {}
    assert flock_metrics(recording, scenario)["consensus_rho_mps"] is None
    recording, scenario = _run("flock_acoustic", 5.0, "agent.consensus={kind: thesis}")
    metrics = flock_metrics(recording, scenario)
    assert metrics["flock_lyapunov_thesis_falls"] is None
    assert metrics["consensus_rho_mps"] > 0.0
    lost = replace(recording, lost_at_s=np.array([np.nan, 3.0, np.nan, np.nan]))
    assert flock_metrics(lost, scenario)["consensus_bound_holds"] is None


def test_a_vehicle_without_a_flock_has_none_of_this():
    assert _metrics("ch2_pfpd", 1.0) == {}
