"""Claims about the scenario `torpedo_formation`: it changes its shape under way, and what is refused."""

import math

import numpy as np
import pytest

from auv_core.params import ConfigError
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.courses.fleet import fleet_metrics
from auv_experiment.metrics.distances import pair_distances_m
from auv_experiment.scenario.loading import load_scenario

SPACING_M, SWITCH_AT_S, MOVE_S = 15.0, 500.0, 200.0


def test_a_move_that_is_too_fast_for_a_vehicle_is_refused_at_load():
    with pytest.raises(ConfigError, match=r"params\.move_s: 200\.0 is not allowed; allowed: at least 211 s"):
        load_scenario("torpedo_formation", overrides=("agent.fleet.params.next_shape=column",))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_the_fleet_changes_its_shape_and_keeps_apart(seed):
    scenario = load_scenario("torpedo_formation", seed=seed)
    recording = run_in_process(scenario)
    metrics = fleet_metrics(recording, scenario)
    assert metrics["fleet_formed_at_s"] < SWITCH_AT_S
    assert metrics["coordination_error_p95_m"] < 1.0
    assert metrics["cross_track_max_m"] < 1.0
    moving = recording.t_s >= SWITCH_AT_S
    assert pair_distances_m(recording)[moving].min() > SPACING_M / math.sqrt(2.0)
    depths_m = recording.position_ned_m[-1, :, 2]
    assert np.abs(depths_m - (30.0, 30.0, 36.0, 36.0, 42.0)).max() < 0.3
