"""Claims about the numbers and the figures of runs to a region, on recordings made by hand."""

import json

import numpy as np
import pytest

from auv_experiment.figures.files import save_figures
from auv_experiment.figures.region import region_drawers
from auv_experiment.metrics.region import region_metrics, ring_of
from auv_experiment.recording import Recording
from auv_experiment.scenario.loading import load_scenario

SCENARIO = load_scenario("ch4_region", overrides=["period_s=1.0", "dt_s=0.1"])


def _recording(tracks):
    """Return a recording in which vehicle i is at `tracks[i][k]`, metres from the ring's centre, at k s."""
    positions = np.array(tracks, dtype=float).swapaxes(0, 1) + 10.0
    recording = Recording.empty(["auv_1", "auv_2", "auv_3"], np.arange(len(positions), dtype=float))
    recording.position_ned_m[:] = positions
    recording.velocity_body[:] = 0.0
    recording.velocity_body[2, 1, :3] = (3.0, 0.0, 4.0)
    recording.command[:] = 0.0
    recording.command[0, 2, :3] = (0.0, -60.0, 80.0)
    return recording


COMES_AND_STAYS = [(6.0, 0.0, 0.0), (1.0, 0.0, 0.0), (3.0, 0.0, 0.0), (2.54, 0.0, 0.0), (2.53, 0.0, 0.0)]
LEAVES = [(0.0, 6.0, 0.0), (0.0, 1.0, 0.0), (0.0, 2.0, 0.0), (0.0, 2.0, 0.0), (0.0, 2.0, 1.5)]
NEVER_OUT = [(-1.0, 0.0, 0.1)] * 5


def test_arrival_is_when_a_vehicle_stays():
    metrics = region_metrics(_recording([COMES_AND_STAYS, LEAVES, NEVER_OUT]), SCENARIO)
    assert metrics["ring_first_inside_s"] == [1.0, 1.0, 0.0]
    assert metrics["ring_reached_s"] == [3.0, None, 0.0]
    assert metrics["ring_distance_final_m"] == pytest.approx([0.03, 1.0, 0.0])
    assert metrics["axis_distance_final_m"] == pytest.approx([2.53, 2.0, 1.0])
    np.testing.assert_allclose(metrics["position_final_ned_m"][1], (10.0, 12.0, 11.5))


def test_extremes():
    metrics = region_metrics(_recording([COMES_AND_STAYS, LEAVES, NEVER_OUT]), SCENARIO)
    assert metrics["speed_max_mps"] == pytest.approx(5.0)
    assert metrics["force_max_n"] == pytest.approx(100.0)
    assert metrics["pair_distance_min_at_s"] == 1.0
    json.dumps(metrics, allow_nan=False)


def test_a_law_without_a_ring_has_no_such_numbers():
    scenario = load_scenario("ch5_four_leaders")
    recording = Recording.empty([vehicle.id for vehicle in scenario.vehicles], np.arange(3.0))
    assert ring_of(scenario) is None
    assert region_metrics(recording, scenario) == {}
    assert region_drawers(recording, scenario) == {}


def test_figures_are_drawn(tmp_path):
    drawers = region_drawers(_recording([COMES_AND_STAYS, LEAVES, NEVER_OUT]), SCENARIO)
    figures = save_figures(drawers, SCENARIO, tmp_path).figures
    assert [figure.path.stem for figure in figures] == [
        "region_space",
        "region_plan",
        "region_distances",
        "region_forces",
    ]
    assert all(figure.path.stat().st_size > 5000 and figure.caption.endswith(".") for figure in figures)
