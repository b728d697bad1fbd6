"""Claims about Lyapunov candidates as data: an increase is found, and the gap of the proof is named."""

import numpy as np
import pytest

from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.lyapunov import candidate_series, lyapunov_metrics
from auv_experiment.scenario.loading import load_scenario


def flown(name, duration_s, *overrides):
    scenario = load_scenario(name, duration_s=duration_s, overrides=overrides)
    return run_in_process(scenario), scenario


def test_every_candidate_of_augmented_pd_falls_and_none_is_explained_away():
    metrics = lyapunov_metrics(*flown("ch2_pfapd_corrected", 60.0))
    assert metrics["lyapunov_thesis_falls"] is True
    assert metrics["lyapunov_corrected_falls"] is True
    assert metrics["lyapunov_thesis_rise_ratio"] == 0.0
    assert metrics["lyapunov_thesis_first_rise_s"] is None
    assert "lyapunov_proof_gap" not in metrics


def test_pd_rises_once_it_only_trails_the_path_and_the_gap_is_told():
    metrics = lyapunov_metrics(*flown("ch2_pfpd", 60.0))
    assert metrics["lyapunov_thesis_falls"] is False
    assert 10.0 < metrics["lyapunov_thesis_first_rise_s"] < 30.0
    assert 0.0 < metrics["lyapunov_thesis_largest_rise_ratio"] < 1e-3
    assert "nu^T grad U" in metrics["lyapunov_proof_gap"]


def test_the_energy_of_a_group_is_one_series_and_falls():
    recording, scenario = flown("ch4_region", 10.0)
    (series,) = candidate_series(recording, scenario).values()
    assert series.shape == (recording.n_ticks, 1)
    assert (np.diff(series[:, 0]) <= 1e-9 * series.max()).all()


def test_a_rise_of_more_than_a_billionth_is_found():
    recording, scenario = flown("ch2_pfapd_corrected", 40.0)
    recording.velocity_body[300, 0, 0] += 0.01
    metrics = lyapunov_metrics(recording, scenario)
    assert metrics["lyapunov_thesis_falls"] is False
    assert metrics["lyapunov_thesis_first_rise_s"] == pytest.approx(29.9)


def test_a_corrected_adaptive_law_falls_and_has_a_gap_of_its_own():
    recording, scenario = flown("ch3_circle_corrected", 10.0)
    metrics = lyapunov_metrics(recording, scenario)
    assert metrics["lyapunov_corrected_falls"] is True
    assert candidate_series(recording, scenario)["corrected"].shape == (recording.n_ticks, 3)


def test_a_flock_over_velocity_controllers_has_no_candidate_here():
    assert lyapunov_metrics(*flown("ch5_one_leader", 1.0)) == {}
