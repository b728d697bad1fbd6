"""Claims about real time: one epoch, bags that replay, and the flight of lock-step except for some delay."""

import json
import math
import os
import subprocess
import sys
import threading
import time
from collections import Counter

import numpy as np
import pytest
import yaml

pytest.importorskip("rclpy")

from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from ros_desk import desk, domain_id

from auv_bag.bag import Bag
from auv_core.models import make_model
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.recording_from_bag import read_recording
from auv_experiment.scenario.loading import list_scenarios, load_scenario

pytestmark = [pytest.mark.ros, pytest.mark.alone]

PATIENCE_S = 120.0
SHORT_S = 3.0
SHORT = (
    "flock_acoustic",
    "ch2_pfpd",
    pytest.param("ch4_region_limited", marks=pytest.mark.slow),
)
WITH_ACTUATORS = ("torpedo_fleet", "hover_thrusters", "formation_switching", "mixed_fleet")
FULL_LENGTH = ("compare_path_laws", "ch4_region", "swarm")
LATE_S, NEAR_M = 0.2, 0.1
"""How far from lock-step on a busy machine: two ticks' delay of a command, and a third of a hull's radius."""
FLIGHTS, KEPT_UP = 3, 0.98
SHIPPED = [name for name, _ in list_scenarios()]


def fly(name, out_dir, duration_s=None):
    """Fly in real time and return the finished command and the results folder."""
    command = [
        sys.executable,
        "-m",
        "auv_bringup.tools.run",
        name,
        "--mode",
        "realtime",
        "--layout",
        "single",
    ]
    command += ["--no-figures", "--out", str(out_dir)]
    if duration_s is not None:
        command += ["--duration", str(duration_s)]
    limit_s = PATIENCE_S + load_scenario(name, duration_s=duration_s).duration_s
    done = subprocess.run(command, capture_output=True, text=True, timeout=limit_s, check=False)
    (folder,) = out_dir.iterdir()
    return done, folder


def fly_undisturbed(name, out_dir, duration_s=None):
    """Fly; again, a few times, where the machine was too busy for the agents to act in every tick."""
    for attempt in range(FLIGHTS):
        done, folder = fly(name, out_dir / str(attempt), duration_s)
        scenario = load_scenario(str(folder / "scenario.yaml"))
        references = {f"/{vehicle.id}/reference" for vehicle in scenario.vehicles}
        acted = sum(1 for _ in Bag(folder).messages(references)) / len(references)
        if acted > KEPT_UP * scenario.ticks:
            break
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def check_time_base(folder, scenario):
    """Hold every message to one epoch, every topic to the order of time, the bag to the length of the run."""
    bag = Bag(folder)
    assert bag.complete
    assert "/clock" not in bag.topics
    first_ns, last_ns = bag.span_ns()
    assert abs(time.time() - 1e-9 * last_ns) < 600.0
    assert scenario.duration_s - 0.5 < 1e-9 * (last_ns - first_ns) < scenario.duration_s + 4.0
    states = {f"/{vehicle.id}/{name}" for vehicle in scenario.vehicles for name in ("state", "nav")}
    last_ticks = dict.fromkeys(states, -1)
    for message in bag.messages(states):
        state = bag.decode(message)
        assert state.tick > last_ticks[message.topic]
        last_ticks[message.topic] = state.tick
        stamp_ns = state.header.stamp.sec * 10**9 + state.header.stamp.nanosec
        assert abs(stamp_ns - first_ns - state.tick * scenario.period_s * 1e9) < 1e4
        assert message.time_ns == stamp_ns
    assert min(last_ticks.values()) >= scenario.ticks - 2


def check_replay(folder, scenario):
    """Publish the bag quickly, and find it as long as the run."""
    command = [sys.executable, "-m", "auv_bringup.tools.replay", str(folder), "--rate", "20", "--delay", "0"]
    limit_s = PATIENCE_S + scenario.duration_s
    done = subprocess.run(command, capture_output=True, text=True, timeout=limit_s, check=False)
    assert done.returncode == 0, done.stderr
    assert "the bag has no messages for" not in done.stderr
    played_s = float(done.stdout.split(" s of the bag")[0].split()[-1])
    assert played_s == pytest.approx(scenario.duration_s, abs=4.0)


def check_against_lockstep(folder, scenario):
    """Compare paths and metrics with the run in one process, whose numbers are those of lock-step."""
    recorded, expected = read_recording(folder, scenario), run_in_process(scenario)
    assert len(recorded.t_s) >= len(expected.t_s) - 2
    rows = min(len(recorded.t_s), len(expected.t_s))
    ours, theirs = recorded.position_ned_m[:rows], expected.position_ned_m[:rows]
    speed_mps = np.linalg.norm(np.diff(theirs, axis=0), axis=-1).max() / scenario.period_s
    allowed_m = NEAR_M + LATE_S * speed_mps
    is_known = np.isfinite(ours).all(axis=-1)
    assert is_known.mean() > KEPT_UP  # of several ticks that a vehicle catches up it publishes the last
    assert np.linalg.norm(ours - theirs, axis=-1)[is_known].max() < allowed_m
    metrics = json.loads((folder / "metrics.json").read_text(encoding="utf-8"))
    wanted = compute_metrics(expected, scenario, mode="inprocess", real_time_factor=1.0)
    assert metrics["duration_s"] == pytest.approx(wanted["duration_s"], abs=2.5 * scenario.period_s)
    assert metrics["lost_vehicles"] == wanted["lost_vehicles"]
    assert metrics["collision"] == wanted["collision"]
    assert metrics["safe_command_ratio"] == pytest.approx(wanted["safe_command_ratio"], abs=0.02)
    for name in ("control_effort_n2s", "packets_sent"):
        if wanted.get(name) is not None:
            assert metrics[name] == pytest.approx(wanted[name], rel=0.2), name
    if wanted["pair_distance_min_m"] is not None:
        assert metrics["pair_distance_min_m"] == pytest.approx(wanted["pair_distance_min_m"], abs=allowed_m)


def check(folder):
    scenario = load_scenario(str(folder / "scenario.yaml"))
    check_time_base(folder, scenario)
    check_replay(folder, scenario)
    check_against_lockstep(folder, scenario)


@pytest.mark.parametrize("name", SHORT)
def test_a_short_flight_has_one_epoch_replays_and_is_that_of_lockstep(name, tmp_path):
    check(fly_undisturbed(name, tmp_path, SHORT_S))


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_the_first_20_s_of_every_scenario_are_those_of_lockstep(name, tmp_path):
    check(fly_undisturbed(name, tmp_path, 20.0))


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("name", FULL_LENGTH)
def test_a_flight_of_full_length_is_that_of_lockstep(name, tmp_path):
    check(fly_undisturbed(name, tmp_path))


def command_topics(scenario):
    """Return the topics of commands and of actuators' outputs of every vehicle that has such actuators."""
    names = {"fins": "cmd_fins", "thrusters": "cmd_thrusters"}
    driven = [
        (vehicle.id, names[kind])
        for vehicle, kind in zip(scenario.vehicles, scenario.commands, strict=True)
        if kind in names
    ]
    return [f"/{vehicle}/{name}" for vehicle, command in driven for name in (command, "actuators")]


def wait_for_all_nodes(run, console):
    """Wait until a run command has said so on its console."""
    pause, deadline_s = threading.Event(), time.monotonic() + PATIENCE_S
    while "all nodes are up" not in console.read_text():
        assert time.monotonic() < deadline_s, console.read_text()
        assert run.poll() is None, console.read_text()
        pause.wait(0.02)


def heard(topic, environ):
    """Return two messages of a topic as `./scripts/topic echo` prints them."""
    command = [sys.executable, "-m", "auv_bringup.tools.topic", "echo", topic, "-n", "2"]
    done = subprocess.run(
        command, env=environ, capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )
    assert done.returncode == 0, done.stderr
    return [yaml.safe_load(each) for each in done.stdout.split("---\n")[:2]]


def check_actuators(folder, scenario):
    """Hold commands and outputs of actuators to nearly every tick; the outputs move."""
    bag = Bag(folder)
    topics = command_topics(scenario)
    counts = Counter(message.topic for message in bag.messages(set(topics)))
    assert all(counts[topic] > KEPT_UP * scenario.ticks for topic in topics), counts
    recording = read_recording(folder, scenario)
    for index, vehicle in enumerate(scenario.vehicles if topics else ()):
        n_actuators = len(make_model(vehicle.model).actuators)
        if n_actuators == 0:
            continue
        outputs = recording.actuator_output[:, index, :n_actuators]
        known = outputs[np.isfinite(outputs).all(axis=1)]
        assert len(known) > KEPT_UP * len(outputs)
        assert np.ptp(known, axis=0).max() > 0.0


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("name", WITH_ACTUATORS)
def test_a_minute_on_fins_or_thrusters_or_in_formation_is_that_of_lockstep(name, tmp_path):
    folder = fly_undisturbed(name, tmp_path, 60.0)
    check(folder)
    check_actuators(folder, load_scenario(str(folder / "scenario.yaml")))


@pytest.mark.slow
@pytest.mark.parametrize("name", WITH_ACTUATORS[:2])
def test_commands_and_outputs_of_actuators_can_be_heard_by_the_topic_command(name, tmp_path):
    scenario = load_scenario(name)
    environ = {**os.environ, "ROS_DOMAIN_ID": str(domain_id())}
    command = [sys.executable, "-m", "auv_bringup.tools.run", name, "--mode", "realtime", "--duration", "40"]
    console = tmp_path / "console"
    with console.open("wb") as stream:
        run = subprocess.Popen(
            [*command, "--layout", "single", "--no-figures", "--out", str(tmp_path / "results")],
            env=environ, stdout=stream, stderr=stream,
        )  # fmt: skip
    try:
        wait_for_all_nodes(run, console)
        command_topic, output_topic = command_topics(scenario)[:2]
        first, second = heard(command_topic, environ)
        assert first["header"]["frame_id"] == "auv_1/base_link_frd"
        assert first["header"]["stamp"] != second["header"]["stamp"]
        output, _ = heard(output_topic, environ)
        actuators = make_model(scenario.vehicles[0].model).actuators
        assert output["names"] == [actuator.name for actuator in actuators]
        assert output["units"] == [actuator.unit for actuator in actuators]
        assert all(math.isfinite(number) for number in output["outputs"])
        assert run.wait(PATIENCE_S) == 0, console.read_text()
    finally:
        run.kill()
        run.wait()


def values_to_set():
    """Return a parameter of every kind that ROS itself declares, with a value that would change it."""
    yes = ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=True)
    number = ParameterValue(type=ParameterType.PARAMETER_INTEGER, integer_value=1)
    return [
        Parameter(name="use_sim_time", value=yes),
        Parameter(name="start_type_description_service", value=yes),
        Parameter(name="qos_overrides./parameter_events.publisher.depth", value=number),
        Parameter(name="mode", value=ParameterValue(type=ParameterType.PARAMETER_STRING, string_value="x")),
    ]


def test_no_parameter_of_a_node_that_flies_can_be_set_and_the_flight_goes_on(tmp_path):
    command = [
        sys.executable,
        "-m",
        "auv_bringup.tools.run",
        "ch2_pfpd",
        "--mode",
        "realtime",
        "--duration",
        "6",
    ]
    command += ["--no-figures", "--out", str(tmp_path / "results")]
    environ = {**os.environ, "ROS_DOMAIN_ID": str(domain_id())}
    console = tmp_path / "console"
    with console.open("wb") as stream:
        run = subprocess.Popen(command, env=environ, stdout=stream, stderr=stream)
    try:
        wait_for_all_nodes(run, console)
        with desk() as at:
            for node in ("/clock_node", "/acoustic_relay_node", "/auv_1/vehicle_node", "/auv_1/agent_node"):
                client = at.node.create_client(SetParameters, f"{node}/set_parameters")
                at.until(client.service_is_ready, f"{node} is there")
                answer = client.call_async(SetParameters.Request(parameters=values_to_set()))
                at.until(answer.done, f"{node} answers")
                assert [each.successful for each in answer.result().results] == [False] * 4
                assert "use_sim_time" in answer.result().results[0].reason
        assert run.wait(PATIENCE_S) == 0, console.read_text()
    finally:
        run.kill()
        run.wait()
    (folder,) = (tmp_path / "results").iterdir()
    check_time_base(folder, load_scenario(str(folder / "scenario.yaml")))
