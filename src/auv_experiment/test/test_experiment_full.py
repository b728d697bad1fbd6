"""Claims over the full 650 s: the numbers of ch. 5 in the spec, and the main job for ten seeds."""

import pytest

from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.scenario.loading import load_scenario

DISTANCE_M, APPROACH_S, ERROR_M = 0.003, 0.1, 0.005

# Spec of ch. 5, section 3 and its last paragraph (obstacles); continuous time, 650 s.
SPEC = {
    "ch5_four_leaders": {
        "pair_distance_settled_min_m": (1.5950, DISTANCE_M),
        "pair_distance_settled_max_m": (1.5950, DISTANCE_M),
        "pair_distance_min_m": (1.451, DISTANCE_M),
        "approach_time_2pct_s": (3.90, APPROACH_S),
        "centroid_path_rms_m": (0.1000, ERROR_M),
        "consensus_error_max_m": (0.2895, ERROR_M),
    },
    "ch5_one_leader": {
        "pair_distance_settled_min_m": (1.5908, DISTANCE_M),
        "pair_distance_settled_max_m": (1.6078, DISTANCE_M),
        "pair_distance_min_m": (1.449, DISTANCE_M),
        "approach_time_2pct_s": (4.00, APPROACH_S),
        "centroid_path_rms_m": (0.1749, ERROR_M),
        "consensus_error_max_m": (0.2680, ERROR_M),
    },
    "ch5_one_leader_blind": {
        "pair_distance_settled_min_m": (1.7171, DISTANCE_M),
        "pair_distance_settled_max_m": (1.8844, DISTANCE_M),
        "pair_distance_min_m": (1.605, DISTANCE_M),
        "approach_time_2pct_s": (56.4, APPROACH_S),
        "centroid_path_rms_m": (1.8759, ERROR_M),
        "consensus_error_max_m": (0.2697, ERROR_M),
    },
    "ch5_obstacles": {
        "obstacle_clearance_min_m": (1.298, DISTANCE_M),
        "centroid_path_rms_m": (0.243, ERROR_M),
    },
}


def _metrics(name, seed=None):
    scenario = load_scenario(name, seed=seed)
    assert scenario.duration_s == 650.0
    return compute_metrics(run_in_process(scenario), scenario, mode="inprocess", real_time_factor=1.0)


@pytest.mark.parametrize("name", SPEC)
def test_chapter_five_gives_the_numbers_of_the_spec(name):
    metrics = _metrics(name)
    for key, (value, tolerance) in SPEC[name].items():
        assert metrics[key] == pytest.approx(value, abs=tolerance), key
    assert not metrics["collision"]


@pytest.mark.parametrize(
    "seed", [1, 2, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(3, 11))]
)
def test_the_main_job_holds_its_bars(seed):
    metrics = _metrics("flock_acoustic", seed)
    assert metrics["pair_distance_min_m"] >= 0.8
    assert metrics["formed_at_s"] is not None
    assert metrics["formed_at_s"] <= 200.0
    assert metrics["pair_distance_formed_min_m"] >= 1.0
    assert metrics["pair_distance_formed_max_m"] <= 4.0
    assert metrics["centroid_path_formed_rms_m"] <= 2.5
    assert metrics["packet_delivery_ratio"] == pytest.approx(0.80, abs=0.03)
    assert metrics["obstacle_clearance_min_m"] >= 0.5
    assert not metrics["collision"]
