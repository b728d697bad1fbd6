"""Claims about flights of torpedoes: a turn and a dive, a path in a current, what is refused."""

import math

import numpy as np
import pytest

from auv_core import compiled
from auv_core.params import ConfigError
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.path import heading_rad
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.scenario.loading import load_scenario


@pytest.fixture(scope="module")
def stepping():
    """Return the scenario `torpedo_steps`, its recording and its metrics."""
    scenario = load_scenario("torpedo_steps")
    recording = run_in_process(scenario)
    return scenario, recording, compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)


def at(recording, values, *times_s):
    rows = [round(t_s / (recording.t_s[1] - recording.t_s[0])) for t_s in times_s]
    return values[rows, 0].tolist()


def test_turn_and_dive_as_specified(stepping):
    _, recording, _ = stepping
    headings_deg = at(recording, np.degrees(heading_rad(recording)), 12.0, 14.0, 16.0, 20.0, 30.0)
    assert headings_deg == pytest.approx([8.97, 17.77, 24.16, 29.75, 30.91], abs=0.1)
    depths_m = at(recording, recording.position_ned_m[..., 2], 14.0, 20.0, 30.0, 40.0, 60.0)
    assert depths_m == pytest.approx([10.605, 12.842, 16.342, 19.632, 20.021], abs=0.01)


def test_metrics_of_turn_and_dive(stepping):
    _, _, metrics = stepping
    assert metrics["heading_settling_1deg_s"] == pytest.approx(10.0 + 9.0, abs=0.3)
    assert math.degrees(metrics["heading_overshoot_rad"]) == pytest.approx(0.99, abs=0.05)
    assert metrics["depth_settling_0p2m_s"] == pytest.approx(10.0 + 40.2, abs=0.5)
    assert metrics["depth_overshoot_m"] == pytest.approx(0.53, abs=0.02)
    assert metrics["cross_track_rms_m"] is None
    assert metrics["safe_command_ratio"] == 0.0


def test_commands_and_outputs_of_the_actuators_are_recorded(stepping):
    _, recording, _ = stepping
    assert recording.actuator_command.shape == (900, 1, 3)
    assert recording.actuator_output.shape == (901, 1, 3)
    rudder_rad = recording.actuator_output[..., 0]
    assert rudder_rad.max() == pytest.approx(math.radians(15.0), rel=1e-6)
    assert at(recording, rudder_rad, 10.0)[0] < 0.01 < at(recording, rudder_rad, 10.3)[0], "it follows"
    assert recording.law_state.shape == (900, 1, 10)


def test_the_horizontal_plane_alone_is_the_published_program():
    scenario = load_scenario(
        "torpedo_steps",
        duration_s=41.0,
        overrides=["vehicles.0.model.params.hull.cross_flow=horizontal"],
    )
    recording = run_in_process(scenario)
    headings_deg = at(recording, np.degrees(heading_rad(recording)), 12.0, 14.0, 16.0, 20.0, 30.0)
    assert headings_deg == pytest.approx([8.98, 17.85, 24.22, 29.75, 30.90], abs=0.1)
    depths_m = at(recording, recording.position_ned_m[..., 2], 14.0, 20.0, 30.0, 40.0)
    assert depths_m == pytest.approx([10.654, 12.883, 16.338, 19.617], abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("crab", ["measured", "alos", "ilos", "none"])
def test_a_racetrack_in_a_current(crab):
    """The bars are those of the specification, 1.3 times its worst of four directions and 0.05 m."""
    scenario = load_scenario("torpedo_path", overrides=[f"agent.course.params.crab.kind={crab}"])
    metrics = compute_metrics(run_in_process(scenario), scenario, mode="inprocess", real_time_factor=1.0)
    bars = {"measured": (0.18, 0.53), "alos": (1.48, 3.17)}
    rms_m, max_m = bars.get(crab, (8.0, 8.0))
    assert metrics["cross_track_rms_m"] < rms_m
    assert metrics["cross_track_max_m"] < max_m
    if crab == "none":
        assert metrics["cross_track_rms_m"] > 1.0, "plain line of sight is carried off its path"


@pytest.mark.slow
@pytest.mark.parametrize("current_ned_mps", [(0.3, 0.0), (0.0, 0.3), (-0.3, 0.0), (0.0, -0.3)])
def test_a_survey_in_a_current(current_ned_mps):
    """The bars are those of the specification."""
    north_mps, east_mps = current_ned_mps
    override = f"environment.current_ned_mps=[{north_mps}, {east_mps}, 0]"
    scenario = load_scenario("torpedo_lawnmower", overrides=[override])
    metrics = compute_metrics(run_in_process(scenario), scenario, mode="inprocess", real_time_factor=1.0)
    assert metrics["cross_track_rms_m"] < 1.3 * 0.20 + 0.05
    assert metrics["cross_track_max_m"] < 1.3 * 0.60 + 0.05


@pytest.mark.parametrize(
    ("name", "overrides", "words"),
    [
        (
            "torpedo_path",
            ["agent.course.params.path.params.radius_m=30"],
            r"agent\.course\.params\.lane: a curve of 30 m .* is not allowed; allowed: at least 3",
        ),
        (
            "torpedo_path",
            ["environment.current_ned_mps=[0, 0.9, 0]"],
            r"agent\.course\.params\.lane: 1\.5 m/s .*; allowed: none in a current of 0\.9 m/s, .* 0\.877 m",
        ),
        (
            "torpedo_path",
            ["environment.current_ned_mps=[0, 0.8, 0]"],
            r"agent\.course\.params\.lane: 1\.5 m/s .* is not allowed; allowed: 1\.6 to 1\.75 m/s",
        ),
        (
            "torpedo_lawnmower",
            ["agent.course.params.loiter_radius_m=20"],
            r"agent\.course\.params\.loiter_radius_m: 20\.0 is not allowed; allowed: at least 3.* m",
        ),
        (
            "hover_thrusters",
            ["vehicles.0.propeller_limit_rpm=800"],
            r"vehicles\[0\]\.propeller_limit_rpm: 800\.0 is not allowed; allowed: null, since",
        ),
        (
            "torpedo_steps",
            ["agent.course.params.speed_mps=0.5"],
            r"agent\.course\.params\.speed_mps: 0\.5 is not allowed; allowed: 0\.8 to 2\.55 m/s",
        ),
        (
            "torpedo_steps",
            ["agent.hold_s=5"],
            r"agent\.hold_s: 5\.0 is not allowed; allowed: 0, since vehicles",
        ),
        (
            "torpedo_steps",
            ["sampling=continuous"],
            r"sampling: 'continuous' is not allowed; allowed: sampled, for the controller autopilot",
        ),
        (
            "torpedo_steps",
            ["vehicles.0.model={preset: odin}"],
            r"agent\.controller\.kind: 'autopilot' is not allowed; allowed: a controller that gives",
        ),
    ],
)
def test_what_a_torpedo_cannot_do_is_refused_in_one_line(name, overrides, words):
    with pytest.raises(ConfigError, match=words):
        load_scenario(name, overrides=overrides)


def test_after_the_end_of_an_open_path_it_circles_beside_it(monkeypatch):
    monkeypatch.setattr(compiled, "_is_on", True)
    path = "agent.course.params.path.params={legs: 1, leg_m: 30.0}"
    scenario = load_scenario("torpedo_lawnmower", duration_s=120.0, overrides=[path])
    recording = run_in_process(scenario)
    away_m = np.hypot(*(recording.position_ned_m[-100:, 0, :2] - (30.0, 50.0)).T)
    assert away_m == pytest.approx(np.full(100, 50.0), abs=0.6)
    assert np.diff(recording.position_ned_m[-100:, 0, 0]).max() < 0.0, "clockwise, past the half"


def test_a_propeller_with_a_fault_turns_no_faster_than_that_leaves():
    scenario = load_scenario(
        "torpedo_steps", duration_s=20.0, overrides=["vehicles.0.propeller_limit_rpm=700"]
    )
    recording = run_in_process(scenario)
    assert recording.actuator_command[..., 2].max() > 895.0, "its computer does not know"
    assert recording.actuator_output[-1, 0, 2] == pytest.approx(700.0, abs=0.1)


def test_without_its_computer_it_rises():
    scenario = load_scenario("torpedo_steps", duration_s=60.0, overrides=["vehicles.0.fails_at_s=9.0"])
    recording = run_in_process(scenario)
    assert (np.diff(recording.position_ned_m[300:500, 0, 2]) < 0.0).all()
    assert abs(recording.position_ned_m[-1, 0, 2]) < 0.2, "and floats"
    assert recording.actuator_output[-1, 0] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)
