"""Scenario, result, simulation and command of the Python interface."""

import copy
import os
import pickle
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import shoal
from auv_core.messages import Wrench
from auv_experiment.figures import by_law
from shoal.commands import COMMANDS, main

LOSS = "acoustics.outage.params.loss_prob"


def test_a_change_of_a_scenario_flies_and_leaves_the_other_alone():
    scenario = shoal.load("flock_acoustic")
    other = scenario.copy()
    other[LOSS] = 1.0
    assert scenario[LOSS] != 1.0
    assert len(shoal.run(other, duration_s=5.0).recording.received) == 0
    assert len(shoal.run(scenario, duration_s=5.0).recording.received) > 0


@pytest.mark.parametrize(
    ("key", "value", "complaint"),
    [
        ("no_such_key", 1, "no_such_key"),
        (LOSS, 2.0, r"loss_prob: 2\.0 is not allowed"),
        ("leaders", ["nobody"], "nobody"),
    ],
)
def test_what_is_not_allowed_is_refused_in_one_line(key, value, complaint):
    scenario = shoal.load("flock_acoustic")
    scenario[key] = value
    with pytest.raises(shoal.ConfigError, match=complaint) as refusal:
        scenario.check()
    assert "\n" not in str(refusal.value)


def test_a_saved_scenario_is_loaded_as_it_was(tmp_path):
    scenario = shoal.load("ch5_one_leader")
    scenario["duration_s"] = 3.0
    assert dict(shoal.load(scenario.save(tmp_path / "mine.yaml"))) == dict(scenario)


def test_a_saved_result_is_opened_as_it_was(tmp_path):
    flown = shoal.run("flock_acoustic", seed=5, duration_s=3.0)
    folder = flown.save(tmp_path / "mine", with_figures=False)
    for path in (folder, folder / "recording.npz"):
        opened = shoal.open(path)
        assert opened.scenario == flown.scenario
        assert opened.mode == "inprocess"
        np.testing.assert_array_equal(opened.recording.position_ned_m, flown.recording.position_ned_m)
        assert opened.metrics["pair_distance_min_m"] == flown.metrics["pair_distance_min_m"]
    with pytest.raises(shoal.ResultsError, match="is not empty"):
        flown.save(folder)


def test_a_saved_result_has_figures_of_the_wanted_formats(tmp_path, monkeypatch):
    all_of = by_law.run_drawers
    monkeypatch.setattr(by_law, "run_drawers", lambda *run: {"plan": all_of(*run)["region_plan"]})
    flown = shoal.run("ch4_region", duration_s=0.5)
    with pytest.raises(shoal.ConfigError, match=r"^formats: 'tiff' is not allowed; allowed: png, pdf, svg$"):
        flown.save(tmp_path / "tiff", formats=["tiff"])
    assert not (tmp_path / "tiff").exists()
    folder = flown.save(tmp_path / "pdf", formats=["pdf"])
    assert {path.name for path in (folder / "figures").iterdir()} == {"plan.pdf", "plan.png"}


def test_what_is_no_result_is_refused_in_one_line(tmp_path):
    with pytest.raises(shoal.ResultsError, match="does not exist"):
        shoal.open(tmp_path / "none")
    with pytest.raises(shoal.ResultsError, match="scenario: missing"):
        shoal.open(tmp_path)


def test_a_figure_of_another_name_is_refused():
    result = shoal.run("flock_acoustic", duration_s=1.0)
    with pytest.raises(shoal.ConfigError, match="'pairs' is not allowed; allowed: plan, "):
        result.figure("pairs")


def test_a_simulation_left_alone_flies_what_run_flies():
    scenario = shoal.load("flock_acoustic")
    scenario["duration_s"] = 3.0
    simulation = shoal.Simulation(scenario, seed=3)
    while not simulation.is_done:
        simulation.step()
    flown = shoal.run(scenario, seed=3).recording
    np.testing.assert_array_equal(simulation.result().recording.position_ned_m, flown.position_ned_m)
    np.testing.assert_array_equal(simulation.result().recording.events, flown.events)
    with pytest.raises(RuntimeError, match="call reset to restart"):
        simulation.step()
    simulation.reset(seed=4)
    assert simulation.time_s == 0.0
    with pytest.raises(RuntimeError, match="no step has been flown yet"):
        simulation.result()


def test_a_simulation_has_a_result_on_its_way_and_flies_on_as_if_there_were_none():
    simulation = shoal.Simulation("flock_acoustic", seed=3, duration_s=6.0)
    on_the_way = []
    while not simulation.is_done:
        simulation.step()
        if round(10 * simulation.time_s) in (1, 33, 45):
            on_the_way.append(simulation.result())
    flown = shoal.run("flock_acoustic", seed=3, duration_s=6.0).recording
    for result in (*on_the_way, simulation.result()):
        recording, k = result.recording, result.recording.n_ticks
        np.testing.assert_array_equal(recording.position_ned_m, flown.position_ned_m[: k + 1])
        np.testing.assert_array_equal(recording.neighbour_covariance, flown.neighbour_covariance[:k])
        np.testing.assert_array_equal(recording.law_state, flown.law_state[:k])
        np.testing.assert_array_equal(recording.events, flown.events[flown.events[:, 0] < k])
        assert result.metrics["duration_s"] == pytest.approx(k * 0.1)
    assert len(on_the_way) == 3


def test_a_copy_of_a_simulation_looks_ahead():
    simulation = shoal.Simulation("flock_acoustic", seed=3)
    simulation.step()
    ahead = copy.deepcopy(simulation)
    ahead.step({"auv_1": [50.0] * 6})
    assert simulation.time_s < ahead.time_s
    other = pickle.loads(pickle.dumps(simulation))
    for each in (simulation, other):
        each.step()
    assert other.states == simulation.states != ahead.states


def test_a_simulation_that_has_diverged_only_begins_anew():
    simulation = shoal.Simulation("ch5_one_leader", seed=3)
    with pytest.raises(shoal.DivergedError):
        simulation.step({"auv_1": [1e308] * 4})
    with pytest.raises(RuntimeError, match="call reset to restart"):
        simulation.step()
    simulation.reset()
    simulation.step()


@pytest.mark.parametrize("numbers", [np.full(6, 3, dtype) for dtype in (np.float32, np.float64, np.int64)])
def test_numbers_of_numpy_are_numbers(numbers):
    a_seed: Any = np.int64(3)
    ours, numpys = (shoal.Simulation("flock_acoustic", seed=seed) for seed in (3, a_seed))
    ours.step({"auv_1": [3.0] * 6})
    numpys.step({"auv_1": numbers})
    assert ours.states == numpys.states


def test_a_scenario_takes_numbers_of_numpy_and_saves_them():
    scenario = shoal.load("flock_acoustic")
    scenario["duration_s"] = np.float64(4.0)
    scenario["environment.current_ned_mps"] = np.array([0.25, 0.0, 0.0])
    assert scenario.resolved().environment.current_ned_mps == (0.25, 0.0, 0.0)
    assert "duration_s: 4.0" in scenario.to_yaml()


def test_a_command_from_outside_moves_its_vehicle_and_no_other():
    pushed, alone = (shoal.Simulation("flock_acoustic", seed=3) for _ in range(2))
    for _ in range(5):
        pushed.step({"auv_2": Wrench((50.0, 0.0, 0.0, 0.0, 0.0, 0.0))})
        alone.step()
    assert pushed.states["auv_2"] != alone.states["auv_2"]
    assert pushed.states["auv_1"] == alone.states["auv_1"]
    assert set(pushed.inboxes) == set(pushed.commands) == set(pushed.vehicle_ids)


@pytest.mark.parametrize(
    ("commands", "complaint"),
    [
        ({"auv_9": [0.0] * 6}, "'auv_9' is not allowed; allowed: auv_1, auv_2, auv_3, auv_4"),
        ({"auv_1": [0.0] * 4}, r"commands\.auv_1: .* allowed: 6 finite numbers"),
        ({"auv_1": [float("nan")] * 6}, "allowed: 6 finite numbers"),
        ({"auv_1": 5.0}, r"commands\.auv_1: 5\.0 is not allowed; allowed: 6 finite numbers"),
        ([[0.0] * 6], "allowed: a mapping by vehicle"),
    ],
)
def test_what_is_no_command_is_refused_and_nothing_is_flown(commands, complaint):
    simulation = shoal.Simulation("flock_acoustic")
    with pytest.raises(shoal.ConfigError, match=complaint):
        simulation.step(commands)
    assert simulation.time_s == 0.0


def test_a_sweep_gives_the_runs_of_its_grid(tmp_path):
    grid = {LOSS: np.array([0, 1])}
    seeds = np.arange(1, 3)
    table = shoal.sweep("flock_acoustic", grid=grid, seeds=seeds, duration_s=3.0, folder=tmp_path, workers=1)
    assert list(table["seed"]) == [1, 2, 1, 2]
    assert set(table["status"]) == {"done"}
    assert (tmp_path / "runs.parquet").is_file()
    summary = shoal.summarise(table)
    nearest = summary[summary["metric"] == "pair_distance_min_m"]
    assert list(nearest[f"scenario.{LOSS}"]) == [0.0, 1.0]
    assert list(nearest["mean"]) == list(table.groupby(f"scenario.{LOSS}")["pair_distance_min_m"].mean())
    assert set(nearest["clusters"]) == {"2 seeds"}
    pooled = shoal.summarise(table, by=[])
    assert set(pooled[pooled["metric"] == "pair_distance_min_m"]["clusters"]) == {"2 seeds"}
    with pytest.raises(shoal.ConfigError, match="by: law is not allowed"):
        shoal.summarise(table, by=["law"])
    with pytest.raises(shoal.ConfigError, match="workers: 0 is not allowed"):
        shoal.sweep("flock_acoustic", seeds=[1], workers=0)
    with pytest.raises(shoal.ConfigError, match="seeds: missing"):
        shoal.sweep(shoal.load("flock_acoustic"))


def test_the_command_names_what_it_knows(capsys):
    assert main(["--help"]) == 0
    help_text = capsys.readouterr().out
    assert all(f"\n  {name} " in help_text for name in COMMANDS)
    assert main(["fly"]) == 2
    assert (
        capsys.readouterr().err == f"error: command: 'fly' is not allowed; allowed: {', '.join(COMMANDS)}\n"
    )
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"shoal {shoal.__version__}\n"


def test_the_command_sets_the_threads_before_numpy_is_there():
    program = "import sys, shoal.commands; print('numpy' in sys.modules)"
    path = os.pathsep.join(sys.path)
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.stdout == "False\n", done.stderr
