"""Claims about flights with thrusters: what a scenario may say, what is recorded, and what a loss costs."""

from pathlib import Path

import numpy as np
import pytest

from auv_core.models import thrusters_of
from auv_core.params import ConfigError
from auv_experiment.figures.by_law import run_drawers
from auv_experiment.figures.files import save_figures
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.recording import Recording
from auv_experiment.scenario.loading import load_scenario

FAULT = "vehicles.1.fault={thruster: 1, t_s: 4.0, known_after_s: 2.0}"
SMALL = "agent.controller={preset: velocity_pi_bluerov2_heavy}"
BARS = ("pair_distance_settled_min_m", "pair_distance_max_after_200s_m", "centroid_path_rms_m")
BLUEROV2 = "vehicles.2.model={preset: bluerov2_heavy}"


def _refused(*overrides, name="hover_thrusters"):
    with pytest.raises(ConfigError) as error:
        load_scenario(name, overrides=overrides)
    return str(error.value)


def test_only_vehicles_with_thrusters_can_lose_one():
    message = (
        "scenario.vehicles[2].fault.thruster: 1 is not allowed; allowed: 0, since the vehicle has no thru"
    )
    assert _refused("vehicles.2.fault={thruster: 1}", name="flock_acoustic").startswith(message)
    message = "scenario.vehicles[0].fault.thruster: 9 is not allowed; allowed: at most 8"
    assert _refused("vehicles.0.fault={thruster: 9}") == message


def test_thrusters_do_not_fly_in_continuous_time():
    assert _refused("sampling=continuous").startswith(
        "scenario.sampling: 'continuous' is not allowed; allowed: sampled, for vehicles with thrusters"
    )


def test_thrusters_need_a_controller_that_gives_a_wrench():
    assert "agent.controller.kind: 'velocity_direct' is not allowed" in _refused(
        "agent.controller={kind: velocity_direct}"
    )


@pytest.fixture(scope="module")
def flight():
    overrides = [FAULT, BLUEROV2, "vehicles.3.model={preset: odin}"]
    scenario = load_scenario("hover_thrusters", overrides=overrides, duration_s=12.0)
    return scenario, run_in_process(scenario)


def test_a_recording_has_commands_and_outputs_of_all_thrusters(flight):
    _, recording = flight
    assert recording.actuator_command.shape == (120, 4, 8)
    assert recording.actuator_output.shape == (121, 4, 8)
    assert np.isfinite(recording.actuator_command[:, :3]).all()
    assert np.isnan(recording.actuator_command[:, 3]).all()
    assert np.isnan(recording.actuator_output[:, 3]).all()
    assert np.isfinite(recording.command).all()
    assert not recording.actuator_output[0, :3].any()


def test_recorded_forces_follow_their_demands_and_give_the_recorded_wrench(flight):
    scenario, recording = flight
    for index in (0, 2):
        thrusters = thrusters_of(scenario.vehicles[index].model)
        demands, outputs = recording.actuator_command[:, index], recording.actuator_output[:, index]
        wrenches = outputs[1:] @ thrusters.matrix().T
        np.testing.assert_allclose(recording.command[:, index], wrenches, atol=1e-9)
        kept = np.exp(-scenario.period_s / thrusters.lag_s)
        np.testing.assert_allclose(outputs[1:], demands + kept * (outputs[:-1] - demands), atol=1e-9)


def test_the_lost_thruster_is_asked_for_nothing_once_the_loss_is_known(flight):
    _, recording = flight
    asked = recording.actuator_command[:, 1, 0] != 0.0
    assert asked[1:60].all()
    assert not asked[60:].any()
    assert np.abs(recording.actuator_output[50:, 1, 0]).max() < 0.01 * np.nanmax(
        np.abs(recording.actuator_command)
    )


def test_a_recording_with_actuators_survives_its_file(flight, tmp_path: Path):
    _, recording = flight
    again = Recording.load(recording.save(tmp_path / "recording.npz"))
    for name in ("command", "actuator_command", "actuator_output"):
        np.testing.assert_array_equal(getattr(again, name), getattr(recording, name))


def test_the_report_s_metrics_are_made_of_such_a_run(flight):
    scenario, recording = flight
    assert compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)["collision"] is False


def test_its_report_shows_the_forces_of_the_vehicles_with_thrusters(flight, tmp_path: Path):
    scenario, recording = flight
    drawn = {name: draw for name, draw in run_drawers(recording, scenario).items() if name == "thrusters"}
    (figure,) = save_figures(drawn, scenario, tmp_path).figures
    assert figure.path.stem == "thrusters"
    assert figure.path.stat().st_size > 10_000
    assert "thrusters" not in run_drawers(recording, load_scenario("flock_acoustic"))


def test_four_small_vehicles_gather_on_their_thrusters_without_shaking():
    overrides = [f"vehicles.{i}.model={{preset: bluerov2_heavy}}" for i in range(4)]
    overrides += ["vehicles.1.fault={thruster: 1, t_s: 20.0}", SMALL, "agent.hold_s=0.0"]
    scenario = load_scenario("hover_thrusters", overrides=overrides, duration_s=40.0)
    recording = run_in_process(scenario)
    metrics = compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)
    assert not metrics["collision"]
    asked = recording.actuator_command[300:]
    assert np.abs(asked).max() < 30.0
    assert np.sqrt((np.diff(asked, axis=0) ** 2).mean()) < 2.0, "N from tick to tick"


@pytest.mark.slow
def test_a_lost_thruster_costs_the_flock_neither_distance_nor_its_path():
    """Means over three seeds: smallest and largest distance within 5 %, the path's rms at most 1.3 times."""
    means = {}
    for name in ("flock_acoustic", "hover_thrusters"):
        found = []
        for seed in (1, 2, 3):
            scenario = load_scenario(name, seed=seed)
            run = run_in_process(scenario)
            metrics = compute_metrics(run, scenario, mode="inprocess", real_time_factor=1.0)
            assert not metrics["collision"]
            found.append([metrics[key] for key in BARS])
        means[name] = np.mean(found, axis=0)
    smallest, largest, path_rms = means["hover_thrusters"] / means["flock_acoustic"]
    assert smallest == pytest.approx(1.0, abs=0.05)
    assert largest == pytest.approx(1.0, abs=0.05)
    assert path_rms <= 1.3
