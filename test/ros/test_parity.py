"""Lock-step runs repeat to the byte, and give the numbers of the run in one process."""

import dataclasses
import hashlib
import json
import os
import subprocess
import sys
from collections import Counter

import numpy as np
import pytest
import yaml

from auv_bag.bag import Bag
from auv_bag.compare import compare_bags
from auv_bag.topics import topics_of_graph
from auv_bringup.launching.layout import LAYOUTS
from auv_core.messages import Outcome
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.recording import acoustic_log
from auv_experiment.recording_from_bag import read_recording
from auv_experiment.scenario.loading import list_scenarios, load_scenario, scenario_to_yaml
from auv_sim.acoustics.event_log import half_duplex_violations
from auv_sim.acoustics.propagation import bellhop

pytestmark = pytest.mark.ros
WITH_THE_LOSSY_RUNS = pytest.mark.xdist_group("lossy_runs")

TOLERANCE = 1e-9
# Times of the water: whole nanoseconds in messages and in recordings of one process alike.
EXACT = {"delay_s", "event_values"}
# What flies in every test run: between them, and with what else flies here, all kinds of the scenarios.
QUICK = (
    "ch2_pfapd_obstacles_corrected",
    "ch3_circle",
    "ch3_spiral_corrected",
    "ch4_region",
    "ch5_communication_obstacles",
    "ch6_obstacles",
    "flock_drift",
    "formation_repair",
    "medium_access",
    "mixed_fleet",
    "passage",
    "torpedo_fleet",
    "torpedo_lawnmower",
    "torpedo_path",
    "torpedo_steps",
)
FLOWN_BELOW = ("flock_acoustic", "flock_sensed", "ch2_pfpd")
# All layouts make one bag (a test says so), so most fly in the one that starts and flies fastest.
WITH_A_PROCESS_PER_NODE = {"ch3_circle", "ch5_one_leader", "flock_drift"}
SHIPPED = [name for name, _ in list_scenarios()]
QUICK_S, LONG_S = 8, 20
FLIGHTS = [pytest.param(name, QUICK_S) for name in QUICK]
FLIGHTS += [pytest.param(name, LONG_S, marks=pytest.mark.slow) for name in SHIPPED]
THRUSTERS = (
    "vehicles.1.fault={thruster: 1, t_s: 2.0, known_after_s: 1.5}",
    "vehicles.2={id: auv_3, model: {preset: bluerov2_heavy}}",
    "vehicles.3={id: auv_4, model: {preset: odin}}",
    "agent.hold_s=0.0",
)
WATER = (
    "agent.neighbours.timeout_s=60",
    (
        "acoustics={propagation: {kind: mackenzie}, modem: {kind: noise_limited}, mac: {kind: csma},"
        " outage: {kind: gilbert_elliott}, silence: {from_s: 4.0, until_s: 4.5},"
        " sonar: {kind: active, params: {max_range_m: 30.0}}}"
    ),
    "environment.navigation={kind: dead_reckoning, params: {fix: lbl, fix_period_s: 3.0}}",
    "environment.current={kind: gauss_markov, params: {memory_s: 5.0}}",
)


def fly(scenario, out_dir, duration_s, *options, limit_s=240):
    """Fly in lock-step with real processes and return the results folder."""
    command = [
        sys.executable,
        "-m",
        "auv_bringup.tools.run",
        scenario,
        "--mode",
        "lockstep",
        "--out",
        str(out_dir),
    ]
    command += ["--duration", str(duration_s), "--no-figures", "--set", "answer_timeout_s=30", *options]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=limit_s, env=os.environ, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    (results_dir,) = out_dir.iterdir()
    return results_dir


def assert_equals_in_process(results_dir, tolerance=TOLERANCE):
    scenario = load_scenario(str(results_dir / "scenario.yaml"))
    recorded = read_recording(results_dir / "bag", scenario)
    expected = run_in_process(scenario)
    assert recorded.vehicle_ids == expected.vehicle_ids
    for field in dataclasses.fields(recorded):
        if field.name != "vehicle_ids":
            ours, theirs = getattr(recorded, field.name), getattr(expected, field.name)
            allowed = 0.0 if field.name in EXACT else tolerance
            np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=allowed, err_msg=field.name)
    assert half_duplex_violations(acoustic_log(recorded)) == []
    return recorded


def kinds_of(part, section=""):
    """Return the plugins that a part of a scenario names, each with its section."""
    if isinstance(part, list):
        return set().union(*(kinds_of(each, section) for each in part))
    if not isinstance(part, dict):
        return set()
    own = {(section, part["kind"])} if isinstance(part.get("kind"), str) else set()
    return own.union(*(kinds_of(value, name) for name, value in part.items()))


@pytest.fixture(scope="module")
def lossy_runs(tmp_path_factory):
    """
    Runs of the main job, 12 s, one seed: a lossy channel and a current. Two with a process per node, one of
    every other layout.
    """
    return [
        fly("flock_acoustic", tmp_path_factory.mktemp(layout), 12, "--seed", "3", "--layout", layout)
        for layout in ("node", *LAYOUTS)
    ]


@WITH_THE_LOSSY_RUNS
@pytest.mark.parametrize("other", range(1, 1 + len(LAYOUTS)), ids=LAYOUTS)
def test_lockstep_runs_with_one_seed_give_byte_identical_bags_in_all_layouts(lossy_runs, other):
    bags = [run / "bag" for run in (lossy_runs[0], lossy_runs[other])]
    assert compare_bags(*bags) == []
    first, second = (hashlib.sha256((bag / "bag_0.mcap").read_bytes()).hexdigest() for bag in bags)
    assert first == second
    assert (bags[0] / "metadata.yaml").read_bytes() == (bags[1] / "metadata.yaml").read_bytes()


@WITH_THE_LOSSY_RUNS
def test_the_runs_lose_packets_and_feel_a_current(lossy_runs):
    scenario = load_scenario(str(lossy_runs[0] / "scenario.yaml"))
    recording = read_recording(lossy_runs[0] / "bag", scenario)
    assert any(scenario.environment.current_ned_mps)
    assert 0 < len(recording.received) < 3 * len(recording.sent)


@WITH_THE_LOSSY_RUNS
def test_topics_come_as_often_as_they_are_declared_to(lossy_runs):
    scenario = load_scenario(str(lossy_runs[0] / "scenario.yaml"))
    counts = Counter(message.topic for message in Bag(lossy_runs[0] / "bag").messages())
    vehicles = [vehicle.id for vehicle in scenario.vehicles]
    topics = topics_of_graph(vehicles, scenario.commands, lockstep=True)
    regular = {topic.name: topic.every_ticks for topic in topics if topic.every_ticks}
    assert len(regular) > 30
    assert {
        name: counts[name]
        for name, every in regular.items()
        if abs(counts[name] - scenario.ticks / every) > 1
    } == {}


@WITH_THE_LOSSY_RUNS
def test_a_lockstep_run_equals_the_run_in_one_process(lossy_runs):
    assert_equals_in_process(lossy_runs[0])


def test_what_flies_in_every_test_run_has_every_kind_of_the_scenarios():
    kinds = {name: kinds_of(yaml.safe_load(scenario_to_yaml(load_scenario(name)))) for name in SHIPPED}
    flown = set().union(*(kinds[name] for name in (*QUICK, *FLOWN_BELOW)))
    assert set().union(*kinds.values()) - flown == set()


@pytest.mark.parametrize(("scenario", "duration_s"), FLIGHTS)
def test_every_scenario_in_lockstep_equals_the_run_in_one_process(scenario, duration_s, tmp_path):
    layout = "node" if scenario in WITH_A_PROCESS_PER_NODE else "single"
    assert_equals_in_process(fly(scenario, tmp_path, duration_s, "--layout", layout))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scenario", "override"),
    [
        ("compare_path_laws", "agent.controller={preset: h_infinity_table_2_1}"),
        ("compare_path_laws", "agent.controller={kind: sliding_mode}"),
        ("flock_acoustic", "agent.separation={kind: adaptive_fuzzy}"),
        ("flock_acoustic", "agent.separation={kind: adaptive_fuzzy_obstacles}"),
        ("flock_acoustic", "agent.controller={kind: velocity_sliding_mode}"),
        ("flock_acoustic", "agent.controller={preset: velocity_h_infinity_odin}"),
        ("ch3_circle_corrected", "agent.controller={kind: formation_sliding_mode}"),
        ("ch3_circle_corrected", "agent.controller={preset: formation_h_infinity_table_3_1}"),
    ],
)
def test_laws_that_no_scenario_names_are_the_same_in_lockstep(scenario, override, tmp_path):
    assert_equals_in_process(fly(scenario, tmp_path, 10, "--set", override, "--layout", "single"))


@pytest.mark.slow
@pytest.mark.skipif(not bellhop.is_installed(), reason="needs ./scripts/setup --with bellhop")
def test_bent_rays_are_the_same_in_lockstep(tmp_path):
    bent = "{kind: bellhop, params: {sound_speed_mps: [1510, 1490], sound_speed_depths_m: [0, 100]}}"
    run = fly("range_sweep", tmp_path, 30, "--set", f"acoustics.propagation={bent}", "--layout", "single")
    assert_equals_in_process(run)


def test_noise_and_failures_of_the_navigation_are_the_same_in_lockstep(tmp_path):
    noisy = "environment.navigation={kind: noisy, params: {failure_prob: 0.1}}"
    options = ("--set", noisy, "--set", "sampling=sampled", "--layout", "vehicle")
    results_dir = fly("ch2_pfpd", tmp_path, 10, *options)
    assert_equals_in_process(results_dir)
    metrics = json.loads((results_dir / "metrics.json").read_text(encoding="utf-8"))
    assert 0.02 < metrics["safe_command_ratio"] < 0.3


def test_sound_sonar_drift_and_a_varying_current_are_the_same_in_lockstep(tmp_path):
    settings = [word for override in WATER for word in ("--set", override)]
    recorded = assert_equals_in_process(fly("flock_acoustic", tmp_path, 6, *settings, "--layout", "vehicle"))
    outcomes = set(recorded.events[:, 1].tolist())
    assert {Outcome.SENT, Outcome.DELIVERED, Outcome.OUTAGE} <= outcomes
    assert len(recorded.contacts) > 0
    assert np.ptp(recorded.nav_position_sd_m) > 0.0


def test_thrusters_with_a_fault_beside_a_hull_without_are_the_same_in_lockstep(tmp_path):
    settings = [word for override in THRUSTERS for word in ("--set", override)]
    recorded = assert_equals_in_process(fly("hover_thrusters", tmp_path, 6, *settings, "--layout", "vehicle"))
    assert np.isfinite(recorded.actuator_output[:, :3]).all()
    assert not recorded.actuator_command[35:, 1, 0].any()
    assert recorded.actuator_command[1:35, 1, 0].all()


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_the_whole_flight_on_thrusters_is_that_of_one_process_to_the_last_bit(tmp_path):
    flown = fly("hover_thrusters", tmp_path, 650, "--layout", "single", limit_s=900)
    assert_equals_in_process(flown, tolerance=0.0)


def test_sensed_and_moving_obstacles_are_the_same_in_lockstep(tmp_path):
    near = (
        "environment.obstacles=[{position_ned_m: [0.0, 10.0, 10.0], known: false},"
        " {position_ned_m: [3.0, 10.0, 10.0], known: false,"
        " motion: {kind: straight, params: {velocity_ned_mps: [-0.3, 0.0, 0.1]}}}]"
    )
    options = ("--set", near, "--set", "agent.hold_s=0.0", "--layout", "vehicle")
    recorded = assert_equals_in_process(fly("flock_sensed", tmp_path, 8, *options))
    (results_dir,) = tmp_path.iterdir()
    blind = load_scenario(
        str(results_dir / "scenario.yaml"), overrides=["agent.obstacle_tracker={kind: none}"]
    )
    assert not np.array_equal(run_in_process(blind).command, recorded.command), "obstacles change commands"
    bag = Bag(results_dir / "bag")
    drawn = {marker.ns for message in bag.messages({"/markers"}) for marker in bag.decode(message).markers}
    assert {"unknown obstacles", "auv_1 sensed"} <= drawn


@WITH_THE_LOSSY_RUNS
def test_another_seed_gives_another_bag(lossy_runs, tmp_path):
    other = fly("flock_acoustic", tmp_path, 2, "--seed", "4", "--layout", "single")
    assert compare_bags(lossy_runs[0] / "bag", other / "bag") != []
