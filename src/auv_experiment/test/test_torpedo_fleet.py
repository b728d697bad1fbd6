"""Claims about the scenario `torpedo_fleet`: what it reaches, and what is refused."""

import numpy as np
import pytest

from auv_core import compiled
from auv_core.params import ConfigError
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.courses.fleet import coordination_error_m
from auv_experiment.metrics.distances import pair_distances_m
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.scenario.loading import load_scenario


def test_differences_of_path_parameters_do_not_count_rounds():
    gammas_m = np.array([[0.0, 99.0, 201.0], [0.0, 1.0, 3.0]])
    assert coordination_error_m(gammas_m, 100.0) == pytest.approx([2.0, 3.0])
    assert coordination_error_m(gammas_m, 0.0) == pytest.approx([201.0, 3.0])


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("agent.fleet.params.depth_m=10.0", r"agent.fleet.params.depth_m: 10.0 is not allowed"),
        (
            "agent.fleet.params.path={kind: racetrack, params: {radius_m: 30.0}}",
            r"agent.fleet.params.lane: a curve of 30 m in the lane at 0 m is not allowed",
        ),
        (
            "agent.fleet.params.speed_mps=0.9",
            r"agent.fleet.params.lane: 0.* m/s in the lane .* is not allowed",
        ),
    ],
)
def test_what_a_fleet_cannot_do_is_refused(override, words):
    with pytest.raises(ConfigError, match=words):
        load_scenario("torpedo_fleet", overrides=[override])


@pytest.mark.slow
def test_the_fleet_forms_and_keeps_its_distances(monkeypatch):
    monkeypatch.setattr(compiled, "_is_on", True)
    scenario = load_scenario("torpedo_fleet")
    recording = run_in_process(scenario)
    metrics = compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)
    assert np.nanmin(pair_distances_m(recording)) > 5.0
    assert metrics["fleet_formed_at_s"] < 620.0
    assert metrics["coordination_error_p95_m"] < 1.0
    assert metrics["cross_track_rms_m"] < 0.1
    assert metrics["cross_track_max_m"] < 0.7
    assert metrics["packets_per_minute"] < 6.5
    assert metrics["turn_away_ratio"] == 0.0
