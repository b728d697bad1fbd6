"""Metrics: values computed by hand, and invariances."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from auv_core.models import hovering
from auv_experiment.metrics.distances import centroid_ned_m, pair_distances_m, vehicle_pairs
from auv_experiment.metrics.gathering import formed_within_m
from auv_experiment.metrics.links import link_counts
from auv_experiment.metrics.run import compute_metrics, metrics_to_json
from auv_experiment.metrics.safety import safe_command_metrics
from auv_experiment.recording import Recording
from auv_experiment.scenario.schema import Obstacle

ISSUE_KEYS = {
    "pair_distance_min_m",
    "formed_at_s",
    "pair_distance_formed_min_m",
    "pair_distance_formed_max_m",
    "pair_distance_settled_min_m",
    "pair_distance_settled_max_m",
    "approach_time_2pct_s",
    "centroid_path_rms_m",
    "consensus_error_max_m",
    "obstacle_clearance_min_m",
    "neighbour_position_rmse_m",
    "packet_delivery_ratio",
    "real_time_factor",
    "seed",
    "scenario",
    "mode",
}


def make_scenario(obstacles: tuple[tuple[float, float, float], ...] = ()) -> Any:
    """A scenario whose path rests at (0, 0, 10) m."""
    return SimpleNamespace(
        name="by_hand",
        vehicles=(),
        sampling="sampled",
        seed=7,
        hull_radius_m=0.3,
        follows="velocity",
        agent=SimpleNamespace(
            flocking=SimpleNamespace(kind="own", params=SimpleNamespace(spacing_m=2.0)),
            separation=None,
            consensus=None,
        ),
        reference_of=lambda: SimpleNamespace(at=lambda t_s: SimpleNamespace(position=(0.0, 0.0, 10.0))),
        environment=SimpleNamespace(obstacles=tuple(Obstacle(position_ned_m=p) for p in obstacles)),
    )


def at_rest(
    positions: list[tuple[float, float, float]], *, duration_s: float, period_s: float = 1.0
) -> Recording:
    """Vehicles that stay where they are."""
    n_ticks = round(duration_s / period_s)
    recording = Recording.empty(
        [f"auv_{i + 1}" for i in range(len(positions))], period_s * np.arange(n_ticks + 1)
    )
    recording.position_ned_m[:] = positions
    return recording


def metrics_of(recording: Recording, scenario: Any = None) -> dict[str, Any]:
    scenario = scenario or make_scenario()
    scenario.handlings = recording.n_vehicles * (hovering(scenario.hull_radius_m),)
    scenario.hull_radii_m = recording.n_vehicles * (scenario.hull_radius_m,)
    return compute_metrics(recording, scenario, mode="inprocess", real_time_factor=50.0)


SQUARE = [(0.0, 0.0, 10.0), (2.0, 0.0, 10.0), (2.0, 2.0, 10.0), (0.0, 2.0, 10.0)]


def test_every_key_is_there_and_the_file_is_strict_json() -> None:
    metrics = metrics_of(at_rest(SQUARE, duration_s=5.0))
    assert set(metrics) >= ISSUE_KEYS

    def refuse(name: str) -> None:
        raise AssertionError(name)

    assert json.loads(metrics_to_json(metrics), parse_constant=refuse) == metrics
    assert (metrics["scenario"], metrics["seed"], metrics["mode"], metrics["real_time_factor"]) == (
        "by_hand",
        7,
        "inprocess",
        50.0,
    )


def test_a_square_at_rest() -> None:
    metrics = metrics_of(at_rest(SQUARE, duration_s=300.0))
    assert metrics["pair_distance_min_m"] == 2.0
    assert metrics["pair_distance_settled_min_m"] == 2.0
    assert metrics["pair_distance_settled_max_m"] == pytest.approx(math.sqrt(8.0))
    assert metrics["formed_at_s"] == 10.0
    assert metrics["approach_time_2pct_s"] == 0.0
    assert metrics["centroid_path_rms_m"] == pytest.approx(math.sqrt(2.0))
    assert metrics["centroid_path_formed_rms_m"] == pytest.approx(math.sqrt(2.0))
    assert metrics["collision"] is False
    assert metrics["collision_at_s"] is None
    assert metrics["lost_vehicles"] == []


def test_what_does_not_exist_is_none() -> None:
    metrics = metrics_of(at_rest(SQUARE, duration_s=50.0))
    absent = {
        "pair_distance_settled_min_m",
        "pair_distance_settled_max_m",
        "centroid_path_rms_m",
        "consensus_error_max_m",
        "obstacle_clearance_min_m",
        "neighbour_position_rmse_m",
        "neighbour_within_2sigma_ratio",
        "packet_delivery_ratio",
        "packet_delay_mean_s",
    }
    assert {key for key in absent if metrics[key] is not None} == set()


def test_one_vehicle_alone_has_no_pairs() -> None:
    metrics = metrics_of(at_rest([(3.0, 0.0, 14.0)], duration_s=120.0))
    assert metrics["pair_distance_min_m"] is None
    assert metrics["formed_at_s"] is None
    assert metrics["centroid_path_rms_m"] == 5.0
    assert metrics["collision"] is False


def test_settled_means_after_100_s() -> None:
    recording = at_rest(SQUARE[:2], duration_s=110.0)
    recording.position_ned_m[100, 1, 0] = 9.0  # at exactly 100 s: not yet
    recording.position_ned_m[101, 1, 0] = 3.0
    metrics = metrics_of(recording)
    assert (metrics["pair_distance_settled_min_m"], metrics["pair_distance_settled_max_m"]) == (2.0, 3.0)


def test_formed_at_the_end_of_the_first_ten_near_seconds() -> None:
    recording = at_rest(SQUARE[:2], duration_s=60.0)
    recording.position_ned_m[:5, 1, 0] = 8.0
    recording.position_ned_m[12, 1, 0] = 4.0  # 4 m is not under 4 m; near again from 13 s on
    recording.position_ned_m[30, 1, 0] = 1.5
    recording.position_ned_m[40, 1, 0] = 6.0
    metrics = metrics_of(recording)
    assert metrics["formed_at_s"] == 23.0
    assert (metrics["pair_distance_formed_min_m"], metrics["pair_distance_formed_max_m"]) == (1.5, 6.0)


def test_the_path_error_counts_from_when_the_flock_has_formed() -> None:
    recording = at_rest(SQUARE, duration_s=60.0)
    recording.position_ned_m[:5, :, 0] += 100.0 * np.arange(4)
    late = metrics_of(recording)
    assert late["formed_at_s"] == 15.0
    assert late["centroid_path_formed_rms_m"] == pytest.approx(math.sqrt(2.0))
    recording.position_ned_m[20:, 0, 0] += 4.0 * math.sqrt(2.0)
    assert metrics_of(recording)["centroid_path_formed_rms_m"] > math.sqrt(2.0)


@pytest.mark.parametrize(
    ("params", "within_m"),
    [
        (SimpleNamespace(spacing_m=4.0, formation_spacing_m=7.0), 8.0),
        (SimpleNamespace(formation_spacing_m=3.0), 6.0),
        (SimpleNamespace(spacing_m=2.0, height_m=lambda _n: 3.0), 5.0),
    ],
)
def test_formed_follows_from_the_spacing_of_the_law(params: Any, within_m: float) -> None:
    scenario = make_scenario()
    scenario.agent.flocking = SimpleNamespace(kind="own", params=params)
    assert formed_within_m(scenario) == within_m
    recording = at_rest(SQUARE[:2], duration_s=60.0)
    recording.position_ned_m[:5, 1, 0] = within_m
    recording.position_ned_m[5:, 1, 0] = 0.99 * within_m
    assert metrics_of(recording, scenario)["formed_at_s"] == 15.0


def test_what_does_not_flock_is_never_formed() -> None:
    scenario = make_scenario()
    scenario.agent.flocking = None
    metrics = metrics_of(at_rest(SQUARE, duration_s=60.0), scenario)
    assert metrics["formed_at_s"] is None
    assert metrics["pair_distance_formed_max_m"] is None
    assert metrics["pair_distance_min_m"] == 2.0


def test_never_formed() -> None:
    recording = at_rest([(0.0, 0.0, 10.0), (2.0, 0.0, 10.0), (5.0, 0.0, 10.0)], duration_s=300.0)
    metrics = metrics_of(recording)
    assert metrics["formed_at_s"] is None
    assert metrics["pair_distance_formed_min_m"] is None
    assert metrics["pair_distance_formed_max_m"] is None
    assert metrics["centroid_path_formed_rms_m"] is None
    assert metrics["pair_distance_min_m"] == 2.0


def test_approach_is_the_tick_after_the_last_excursion() -> None:
    recording = at_rest(SQUARE[:2], duration_s=1000.0)
    recording.position_ned_m[:8, 1, 0] = 5.0
    recording.position_ned_m[15, 1, 0] = 2.5
    assert metrics_of(recording)["approach_time_2pct_s"] == 16.0


def test_no_approach_when_the_last_state_is_outside() -> None:
    recording = at_rest(SQUARE[:2], duration_s=1000.0)
    recording.position_ned_m[-1, 1, 0] = 2.5
    assert metrics_of(recording)["approach_time_2pct_s"] is None


def test_collision_is_a_distance_below_two_hull_radii() -> None:
    recording = at_rest([(0.0, 0.0, 10.0), (0.7, 0.0, 10.0)], duration_s=20.0)
    assert metrics_of(recording)["collision"] is False
    recording.position_ned_m[13, 1, 0] = 0.55
    metrics = metrics_of(recording)
    assert metrics["collision"] is True
    assert metrics["collision_at_s"] == 13.0
    assert metrics["pair_distance_min_m"] == pytest.approx(0.55)


def test_a_lost_vehicle_leaves_the_flock_but_can_still_be_hit() -> None:
    recording = at_rest([(-1.0, 0.0, 10.0), (1.0, 0.0, 10.0), (0.0, 1.0, 10.0)], duration_s=300.0)
    recording.lost_at_s[2] = 50.0
    recording.position_ned_m[60:, 2] = (-1.0, 20.0, 10.0)
    recording.position_ned_m[200, 2] = (-1.0, 0.5, 10.0)  # the wreck drifts against auv_1
    metrics = metrics_of(recording)
    assert metrics["lost_vehicles"] == ["auv_3"]
    assert metrics["pair_distance_min_m"] == 0.5
    assert metrics["collision"] is True
    assert metrics["pair_distance_formed_max_m"] == 2.0
    assert metrics["pair_distance_settled_min_m"] == 2.0
    assert metrics["centroid_path_rms_m"] == 0.0
    np.testing.assert_allclose(
        centroid_ned_m(recording)[[49, 50]], [(0.0, 1.0 / 3.0, 10.0), (0.0, 0.0, 10.0)]
    )


def test_losing_everybody_leaves_no_flock() -> None:
    recording = at_rest(SQUARE, duration_s=300.0)
    recording.lost_at_s[:] = 5.0
    metrics = metrics_of(recording)
    assert metrics["formed_at_s"] is None
    assert metrics["centroid_path_rms_m"] is None
    assert metrics["pair_distance_min_m"] == 2.0


def test_consensus_error_is_the_worst_vehicle_after_100_s() -> None:
    recording = at_rest(SQUARE, duration_s=200.0)  # mean (1, 1, 10)
    recording.centre_ned_m[:] = (1.0, 1.0, 10.0)
    recording.centre_ned_m[100, 0] = (9.0, 1.0, 10.0)
    recording.centre_ned_m[150, 2] = (1.0, 1.0, 10.25)
    recording.centre_ned_m[160, 3] = np.nan
    assert metrics_of(recording)["consensus_error_max_m"] == 0.25


def test_obstacle_clearance_is_from_hull_centre_to_obstacle() -> None:
    recording = at_rest(SQUARE, duration_s=20.0)
    metrics = metrics_of(recording, make_scenario(((5.0, 0.0, 6.0), (50.0, 0.0, 10.0))))
    assert metrics["obstacle_clearance_min_m"] == 5.0


def with_estimates(recording: Recording, error_m: float, sigma_m: float) -> Recording:
    truth = recording.position_ned_m[:-1, np.newaxis] + np.array([error_m, 0.0, 0.0])
    recording.neighbour_position_ned_m[:] = truth
    recording.neighbour_covariance[:] = sigma_m**2 * np.eye(6)
    recording.neighbour_age_s[:] = 0.4
    for i in range(recording.n_vehicles):
        recording.neighbour_position_ned_m[:, i, i] = np.nan
    return recording


def test_neighbour_rmse_and_the_share_inside_two_sigma() -> None:
    recording = with_estimates(at_rest(SQUARE[:2], duration_s=200.0), error_m=0.3, sigma_m=0.1)
    recording.neighbour_position_ned_m[:101] = 1e3  # up to 100 s nothing counts
    recording.neighbour_position_ned_m[101, 0, 1] = np.nan  # nor what does not exist
    metrics = metrics_of(recording)
    assert metrics["neighbour_position_rmse_m"] == pytest.approx(0.3)
    assert metrics["neighbour_within_2sigma_ratio"] == pytest.approx(2.0 / 3.0)
    assert metrics["neighbour_age_mean_s"] == pytest.approx(0.4)


def test_estimates_of_and_by_a_lost_vehicle_do_not_count() -> None:
    recording = with_estimates(at_rest(SQUARE[:3], duration_s=200.0), error_m=0.3, sigma_m=0.1)
    recording.lost_at_s[2] = 20.0
    recording.neighbour_position_ned_m[20:, 2] = 1e3
    recording.neighbour_position_ned_m[20:, :, 2] = 1e3
    assert metrics_of(recording)["neighbour_position_rmse_m"] == pytest.approx(0.3)


def test_delivery_counts_receptions_of_packets_that_were_sent() -> None:
    recording = at_rest(SQUARE[:3], duration_s=10.0)
    recording.sent = np.array([[0, 1, 0], [1, 2, 0], [2, 1, 1], [3, 3, 0]])
    recording.received = np.array(
        [[1, 1, 2, 0], [1, 1, 3, 0], [2, 2, 1, 0], [4, 3, 2, 0], [5, 9, 1, 0], [6, 1, 2, 44]]
    )
    recording.delay_s = np.array([0.1, 0.2, 0.1, 0.2, np.nan, np.nan])
    expected, delivered = link_counts(recording)
    assert expected.tolist() == [[0, 2, 2], [1, 0, 1], [1, 1, 0]]
    assert delivered.tolist() == [[0, 1, 1], [1, 0, 0], [0, 1, 0]]
    metrics = metrics_of(recording)
    assert metrics["packet_delivery_ratio"] == 0.5
    assert metrics["packets_sent"] == 4
    assert metrics["packet_delay_mean_s"] == pytest.approx(0.15)


def test_nobody_listens_on_a_lost_vehicle() -> None:
    recording = at_rest(SQUARE[:3], duration_s=10.0)
    recording.lost_at_s[2] = 4.0
    recording.sent = np.array([[3, 1, 0], [4, 1, 1]])
    recording.received = np.array([[4, 1, 2, 0], [4, 1, 3, 0], [5, 1, 2, 1], [5, 1, 3, 1]])
    recording.delay_s = np.full(4, 0.1)
    expected, delivered = link_counts(recording)
    assert expected[0].tolist() == [0, 2, 1]
    assert delivered[0].tolist() == [0, 2, 1]


def test_numbers_that_are_not_finite_become_none() -> None:
    scenario = make_scenario()
    scenario.handlings = 4 * (hovering(0.3),)
    scenario.hull_radii_m = (0.3, 0.3, 0.3, 0.3)
    metrics = compute_metrics(
        at_rest(SQUARE, duration_s=5.0), scenario, mode="lockstep", real_time_factor=math.inf
    )
    assert metrics["real_time_factor"] is None
    metrics_to_json(metrics)


def test_positions_that_are_missing_make_no_distance() -> None:
    recording = at_rest(SQUARE, duration_s=150.0)
    recording.position_ned_m[120:130, 1] = np.nan
    metrics = metrics_of(recording)
    assert metrics["pair_distance_min_m"] == 2.0
    assert metrics["centroid_path_rms_m"] is not None
    metrics_to_json(metrics)


tracks = hnp.arrays(np.float64, (31, 4, 3), elements=st.floats(-20.0, 20.0, width=32))


def moving(track: np.ndarray) -> Recording:
    recording = at_rest([(0.0, 0.0, 0.0)] * 4, duration_s=5.0 * (len(track) - 1), period_s=5.0)
    recording.position_ned_m[:] = track
    return recording


@settings(max_examples=40, deadline=None)
@given(track=tracks, shift=hnp.arrays(np.float64, 3, elements=st.floats(-50.0, 50.0, width=32)))
def test_pair_distances_do_not_depend_on_the_origin(track: np.ndarray, shift: np.ndarray) -> None:
    np.testing.assert_allclose(
        pair_distances_m(moving(track)), pair_distances_m(moving(track + shift)), rtol=0.0, atol=1e-9
    )


@settings(max_examples=40, deadline=None)
@given(track=tracks, order=st.permutations(range(4)))
def test_metrics_do_not_depend_on_the_order_of_the_vehicles(track: np.ndarray, order: list[int]) -> None:
    first, second = metrics_of(moving(track)), metrics_of(moving(track[:, order]))
    assert first.keys() == second.keys()
    for key, value in first.items():
        assert second[key] == (pytest.approx(value, rel=1e-9) if isinstance(value, float) else value), key


@settings(max_examples=40, deadline=None)
@given(track=tracks)
def test_smallest_distances_are_ordered(track: np.ndarray) -> None:
    metrics = metrics_of(moving(track))
    ever, settled = metrics["pair_distance_min_m"], metrics["pair_distance_settled_min_m"]
    assert ever <= settled <= metrics["pair_distance_settled_max_m"]
    assert metrics["collision"] == (ever < 0.6)


def test_pairs_are_unordered_and_complete() -> None:
    assert vehicle_pairs(3) == [(0, 1), (0, 2), (1, 2)]


def test_safe_commands_are_counted_by_cause():
    recording = Recording.empty(["auv_1", "auv_2"], np.arange(6) * 0.1)
    recording.holding[:3, 0] = 1
    recording.holding[4, 1] = 3
    metrics = safe_command_metrics(recording)
    assert metrics["safe_command_ratio"] == 0.4
    assert metrics["safe_commands_stale_navigation"] == 3
    assert metrics["safe_commands_silent_modem"] == 1
    assert sum(count or 0 for key, count in metrics.items() if key.startswith("safe_commands_")) == 4
    assert safe_command_metrics(Recording.empty(["auv_1"], np.zeros(1)))["safe_command_ratio"] is None
