"""Claims about the metrics of network, navigation and filters: by hand, and on known statistics."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from scipy import stats

from auv_core.messages import Outcome
from auv_experiment.metrics.acoustics import (
    LOSSES,
    acoustics_metrics,
    has_modem,
    is_navigation_exact,
    judged_ticks,
    loss_counts,
    neighbour_nees,
    relative_error_ned,
)
from auv_experiment.metrics.descriptions import MEANINGS
from auv_experiment.metrics.neighbours import tail_metrics
from auv_experiment.metrics.wording import metrics_table
from auv_experiment.recording import Recording


def fleet(n_ticks: int = 200, n: int = 3, period_s: float = 1.0) -> Recording:
    """Vehicles with constant velocities and exact navigation."""
    rng = np.random.default_rng(1)
    recording = Recording.empty([f"auv_{i + 1}" for i in range(n)], period_s * np.arange(n_ticks + 1))
    start_m, velocity_mps = rng.normal(0.0, 5.0, (2, n, 3))
    recording.position_ned_m[:] = start_m + recording.t_s[:, np.newaxis, np.newaxis] * velocity_mps
    recording.nav_position_ned_m[:] = recording.position_ned_m[:-1]
    recording.nav_position_sd_m[:] = 0.0
    return recording


def with_events(recording: Recording, rows: list[tuple[int, ...]], airtime_s: float = 0.5) -> Recording:
    """Rows are (outcome, source, destination, sequence); every packet has 32 bytes."""
    recording.events = np.array([(0, *row, 32) for row in rows], dtype=np.int64)
    recording.event_values = np.tile([1.0, 1.0 + airtime_s, np.nan], (len(rows), 1))
    return recording


def with_estimates(recording: Recording, covariance: np.ndarray, drift_m: Any = 0.0) -> Recording:
    """
    Estimates with errors according to `covariance`, in the frame of navigations with the error `drift_m`.
    """
    rng = np.random.default_rng(2)
    k, n = recording.n_ticks, recording.n_vehicles
    error = rng.multivariate_normal(np.zeros(6), covariance, (k, n, n))
    recording.nav_position_ned_m[:] = recording.position_ned_m[:-1] + drift_m
    own_off_m = recording.nav_position_ned_m - recording.position_ned_m[:-1]
    velocity_mps = (
        np.diff(recording.position_ned_m, axis=0) / np.diff(recording.t_s)[:, np.newaxis, np.newaxis]
    )
    recording.neighbour_position_ned_m[:] = recording.position_ned_m[:-1, np.newaxis] + error[..., :3]
    recording.neighbour_position_ned_m[:] += own_off_m[:, :, np.newaxis]
    recording.neighbour_velocity_ned_mps[:] = velocity_mps[:, np.newaxis] + error[..., 3:]
    recording.neighbour_covariance[:] = covariance
    return recording


SENT, DELIVERED, NOISE, COLLISION = Outcome.SENT, Outcome.DELIVERED, Outcome.NOISE, Outcome.COLLISION
SPREAD = np.random.default_rng(3).normal(size=(6, 6))
COVARIANCE = SPREAD @ SPREAD.T + 0.1 * np.eye(6)


def test_packets_by_hand() -> None:
    recording = with_events(
        fleet(),
        [
            (SENT, 1, 0, 1),
            (SENT, 2, 0, 1),
            (DELIVERED, 1, 2, 1),
            (NOISE, 1, 3, 1),
            (COLLISION, 2, 1, 1),
            (DELIVERED, 2, 3, 1),
        ],
    )
    recording.received = np.array([(2, 1, 2, 1), (2, 2, 3, 1)])
    recording.delay_s = np.array([0.5, 0.7])
    metrics = acoustics_metrics(recording)
    assert metrics["packets_lost"] == 2
    ratios = {outcome: metrics[f"packet_loss_{outcome.name.lower()}_ratio"] for outcome in LOSSES}
    assert ratios == {outcome: 0.25 if outcome in (NOISE, COLLISION) else 0.0 for outcome in LOSSES}
    assert metrics["packet_delay_95pct_s"] == pytest.approx(0.69)
    assert metrics["acoustic_bit_rate_bps"] == pytest.approx(2 * 32 * 8 / 200.0)
    assert metrics["acoustic_load_ratio"] == pytest.approx(2 * 0.5 / 200.0)
    counts = loss_counts(recording)
    assert counts[NOISE][0, 2] == counts[COLLISION][1, 0] == counts[DELIVERED][1, 2] == 1
    assert sum(table.sum() for table in counts.values()) == 4
    json.dumps(metrics, allow_nan=False)


def test_nothing_is_told_where_nothing_is_modelled() -> None:
    assert acoustics_metrics(fleet()) == {}
    assert acoustics_metrics(Recording.empty(["auv_1"], np.arange(1.0))) == {}
    ideal = with_events(fleet(), [(SENT, 1, 0, 1), (DELIVERED, 1, 2, 1)], airtime_s=0.0)
    assert not has_modem(ideal)
    assert acoustics_metrics(ideal) == {}


def test_before_anything_arrives_quantities_are_none() -> None:
    metrics = acoustics_metrics(with_events(fleet(), [(SENT, 1, 0, 1)]))
    assert metrics["packets_lost"] == 0
    nothing = {key for key, value in metrics.items() if value is None}
    assert nothing == {
        *(f"packet_loss_{outcome.name.lower()}_ratio" for outcome in LOSSES),
        "packet_delay_95pct_s",
        "neighbour_age_95pct_s",
        "neighbour_nees_position_mean",
        "neighbour_nees_mean",
        "neighbour_nees_within_95_ratio",
    }


def test_packets_from_addresses_of_nobody_do_not_count() -> None:
    recording = with_events(fleet(), [(DELIVERED, 9, 1, 1), (DELIVERED, 1, 0, 1), (DELIVERED, 1, 2, 1)])
    assert loss_counts(recording)[DELIVERED].sum() == 1


@pytest.mark.parametrize("drift_m", [0.0, np.array([[3.0, 0, 0], [0, -4.0, 0], [0, 0, 0.1]])])
def test_errors_that_the_covariance_tells_give_a_nees_of_their_number(drift_m: Any) -> None:
    recording = with_events(with_estimates(fleet(2000), COVARIANCE, drift_m), [(SENT, 1, 0, 1)])
    metrics = acoustics_metrics(recording, formed_at_s=100.0)
    count = 1900 * 6
    assert metrics["neighbour_nees_position_mean"] == pytest.approx(3.0, abs=4.0 * np.sqrt(6.0 / count))
    assert metrics["neighbour_nees_mean"] == pytest.approx(6.0, abs=4.0 * np.sqrt(12.0 / count))
    within = metrics["neighbour_nees_within_95_ratio"]
    assert within == pytest.approx(0.95, abs=4.0 * np.sqrt(0.95 * 0.05 / count))


def test_filters_that_claim_too_much_are_found_out() -> None:
    recording = with_events(with_estimates(fleet(500), COVARIANCE), [(SENT, 1, 0, 1)])
    recording.neighbour_covariance /= 4.0
    metrics = acoustics_metrics(recording)
    assert metrics["neighbour_nees_mean"] == pytest.approx(24.0, rel=0.1)
    assert metrics["neighbour_nees_within_95_ratio"] < 0.6


def test_tails_are_told_by_the_age_of_the_information() -> None:
    """Estimates with packets over 5 s old claim half of their errors; the others are honest."""
    recording = with_events(with_estimates(fleet(2000), COVARIANCE), [(SENT, 1, 0, 1)])
    age_s = np.arange(2000) % 8.0
    recording.neighbour_age_s[:] = age_s[:, np.newaxis, np.newaxis]
    recording.neighbour_covariance[age_s >= 5.0] /= 4.0
    metrics = tail_metrics(recording)
    for low_s in (0, 2):
        assert metrics[f"neighbour_nees_beyond_95_age_{low_s}s_ratio"] == pytest.approx(0.05, abs=0.015)
        assert metrics[f"neighbour_nees_beyond_997_age_{low_s}s_ratio"] == pytest.approx(0.003, abs=0.003)
    expected = stats.chi2.sf(np.array((7.8147, 13.9314)) / 4.0, 3)
    for name, share in zip(("95", "997"), expected, strict=True):
        assert metrics[f"neighbour_nees_beyond_{name}_age_5s_ratio"] == pytest.approx(share, abs=0.04)
        assert metrics[f"neighbour_nees_beyond_{name}_age_10s_ratio"] is None
    assert set(metrics) <= set(MEANINGS)
    assert tail_metrics(fleet()) == {}


def test_a_shared_drift_is_no_error_of_the_neighbours() -> None:
    recording = with_estimates(fleet(20), 1e-18 * np.eye(6), drift_m=100.0)
    error = relative_error_ned(recording, np.arange(20))
    others = ~np.eye(3, dtype=bool)
    np.testing.assert_allclose(error[:, others], 0.0, atol=1e-6)
    assert np.isnan(error[:, ~others]).all()


def test_a_recording_without_navigation_is_judged_against_the_truth() -> None:
    recording = with_estimates(fleet(20), 1e-18 * np.eye(6))
    recording.nav_position_ned_m[:] = np.nan
    assert is_navigation_exact(recording)
    np.testing.assert_allclose(relative_error_ned(recording, np.arange(20))[:, 0, 1], 0.0, atol=1e-6)


def test_navigation_by_hand() -> None:
    recording = fleet(100)
    recording.nav_position_ned_m[:, 0] += (3.0, 4.0, 0.0)
    recording.nav_position_ned_m[-1, 1] += (0.0, 0.0, 1.0)
    recording.nav_position_sd_m[:] = 5.0
    metrics = acoustics_metrics(recording)
    assert metrics == {
        "navigation_error_rms_m": pytest.approx(np.sqrt((25.0 * 100 + 1.0) / 300)),
        "navigation_error_final_m": pytest.approx(np.sqrt(26.0 / 3)),
        "navigation_nees_mean": pytest.approx(1.0 / 3.0),
    }


def test_a_lost_vehicle_leaves_the_judgement() -> None:
    recording = with_estimates(fleet(50), COVARIANCE)
    recording.nav_position_ned_m[30:, 0] += 1000.0
    recording.lost_at_s[0] = 30.0
    recording.nav_position_sd_m[:] = 1.0
    nees = neighbour_nees(recording, np.arange(50), 3)
    assert np.isfinite(nees[:30, 0, 1]).all()
    assert np.isnan(nees[30:, 0]).all()
    assert np.isnan(nees[30:, :, 0]).all()
    assert acoustics_metrics(recording) == {}, "the others' navigation is exact"


def test_a_covariance_that_is_none_is_left_out() -> None:
    recording = with_estimates(fleet(5), COVARIANCE)
    recording.neighbour_covariance[:, 0] = 0.0
    recording.neighbour_covariance[:, 1] = np.nan
    nees = neighbour_nees(recording, np.arange(5), 6)
    assert np.isnan(nees[:, :2]).all()
    assert np.isfinite(nees[:, 2, :2]).all()


def test_long_runs_are_judged_at_even_steps() -> None:
    assert len(judged_ticks(fleet(100), 40.0)) == 60
    ticks = judged_ticks(fleet(3000, n=16, period_s=0.1), 0.0)
    assert len(ticks) * 256 <= 400_000
    assert set(np.diff(ticks)) == {3}
    assert len(judged_ticks(fleet(100), np.inf)) == 0


def test_the_terminal_leaves_out_causes_to_which_nothing_was_lost() -> None:
    shown = metrics_table(
        {"packet_loss_noise_ratio": 0.0, "packet_loss_outage_ratio": 0.25, "packets_lost": 0}
    )
    assert "outage" in shown
    assert "noise" not in shown
    assert "packets that did not reach a receiver" in shown
