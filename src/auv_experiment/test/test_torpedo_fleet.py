"""Claims about the scenario `torpedo_fleet`: what it reaches, and what is refused."""

import numpy as np
import pytest

from auv_core import compiled
from auv_core.params import ConfigError
from auv_experiment.compose import agent_configs
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.courses.fleet import coordination_error_m, fleet_metrics
from auv_experiment.metrics.distances import is_working, pair_distances_m
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.scenario.loading import load_scenario

WIDE = "{kind: racetrack, params: {radius_m: 250.0}}"
"""A path on which the inner one of eight lanes is fast enough."""


def test_differences_of_path_parameters_do_not_count_rounds():
    gammas_m = np.array([[0.0, 99.0, 201.0], [0.0, 1.0, 3.0]])
    assert coordination_error_m(gammas_m, 100.0) == pytest.approx([2.0, 3.0])
    assert coordination_error_m(gammas_m, 0.0) == pytest.approx([201.0, 3.0])


@pytest.fixture(scope="module")
def losing():
    """Return a recording, in which the first of three vehicles fails after 2 s, and its scenario."""
    vehicles = ", ".join(
        f"{{id: auv_{address}, model: {{preset: remus100}}, speed_mps: 1.5{fails}}}"
        for address, fails in ((1, ", fails_at_s: 2.0"), (2, ""), (3, ""))
    )
    scenario = load_scenario("torpedo_lost", duration_s=4.0, overrides=[f"vehicles=[{vehicles}]"])
    return run_in_process(scenario), scenario


def test_a_vehicle_counts_until_its_computer_fails(losing):
    recording, scenario = losing
    works = is_working(recording, scenario)
    assert works[:10].all()
    assert (works[10:] == [False, True, True]).all()
    metrics = fleet_metrics(recording, scenario)
    pairs_m = pair_distances_m(recording)
    assert metrics["pair_distance_working_min_m"] == min(pairs_m[:10].min(), pairs_m[10:, 2].min())
    assert metrics["wreck_distance_min_m"] == pairs_m[10:, :2].min()
    assert metrics["coordination_error_after_700s_p95_m"] is None


def test_path_parameters_of_vehicles_that_do_not_work_count_for_nothing():
    gammas_m = np.array([[0.0, 3.0, np.nan], [np.nan, np.nan, np.nan]])
    assert coordination_error_m(gammas_m, 100.0) == pytest.approx([3.0, 0.0])


@pytest.mark.parametrize("seed", [1, 2, 77])
@pytest.mark.parametrize("count", [3, 8])
def test_random_starts_in_layers_are_apart_and_at_their_depths(seed, count):
    overrides = [f"vehicles.count={count}", f"agent.fleet.params.path={WIDE}"]
    scenario = load_scenario("torpedo_fleet_modem", seed=seed, overrides=overrides)
    starts = np.array([vehicle.position_ned_m for vehicle in scenario.vehicles])
    assert scenario.agent.fleet is not None
    assert starts[:, 2].tolist() == list(scenario.agent.fleet.params.layer_depths(count))
    places, (first, second) = starts[:, :2], np.triu_indices(count, 1)
    assert np.hypot(*(places - (100.0, 0.0)).T).max() <= 100.0
    assert np.hypot(*(places[first] - places[second]).T).min() >= 60.0
    headings_rad = [vehicle.heading_rad for vehicle in scenario.vehicles]
    assert len(set(headings_rad)) == count
    assert load_scenario("torpedo_fleet_modem", seed=seed, overrides=overrides) == scenario


def test_random_starts_without_layers_are_at_one_depth():
    scenario = load_scenario("torpedo_unsafe", overrides=["random_starts.centre_ned_m.2=5.0"])
    assert {v.position_ned_m[2] for v in scenario.vehicles if v.position_ned_m} == {5.0}


def test_the_fleet_knows_the_cycle_of_its_channel_and_all_starts():
    scenario = load_scenario("torpedo_fleet_modem", overrides=["acoustics.mac.params.slot_s=8"])
    config = agent_configs(scenario)[1]
    assert config.mission.cycle_s == 40.0
    starts = [(v.position_ned_m, v.heading_rad, v.speed_mps) for v in scenario.vehicles]
    assert list(config.mission.starts) == starts
    assert agent_configs(load_scenario("torpedo_path"))[0].mission.starts == ()


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("vehicles.count=8", r"agent.fleet.params.lane: 1.05 m/s in the lane at 45 m is not allowed"),
        (
            "random_starts.separation_m=190",
            r"random_starts: no room for 5 vehicles; allowed: a larger radius_m \(100\) or a smaller sep",
        ),
        ("agent.fleet.params.cycle_s=12", r"agent.fleet.params.cycle_s: 12.0 is not allowed; allowed: 10, "),
        (
            "acoustics.mac={kind: slotted_aloha, params: {slot_s: 2.0}}",
            r"agent.fleet.params.cycle_s: missing; allowed: a number, since acoustics.mac has no cycle",
        ),
        (
            "acoustics.silence={from_s: 9.0, until_s: 8.0}",
            r"acoustics.silence.until_s: 8.0 is not allowed; allowed: at least from_s = 9.0",
        ),
    ],
)
def test_what_does_not_fit_is_refused(override, words):
    with pytest.raises(ConfigError, match=words):
        load_scenario("torpedo_fleet_modem", overrides=[override])


def test_layers_for_starts_need_a_fleet_with_layers():
    with pytest.raises(ConfigError, match=r"random_starts.depths: 'layers' is not allowed; allowed: ball"):
        load_scenario("flock_modem", overrides=["random_starts.depths=layers"])


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
    assert 13.5 < metrics["pair_distance_formed_min_m"] < metrics["pair_distance_formed_max_m"] < 75.0
    assert metrics["coordination_error_p95_m"] < 1.0
    assert metrics["cross_track_rms_m"] < 0.1
    assert metrics["cross_track_max_m"] < 0.7
    assert metrics["packets_per_minute"] < 6.5
    assert metrics["turn_away_ratio"] == 0.0
