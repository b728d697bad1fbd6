"""Whole flights with foreign publishers: they end normally and name the publishers."""

import json
import os
import signal
import subprocess
import sys
from typing import Any

import pytest

pytest.importorskip("rclpy")

import yaml
from geometry_msgs.msg import WrenchStamped
from ros_desk import desk, domain_id, process
from rosgraph_msgs.msg import Clock

from auv_bag.compare import compare_bags
from auv_experiment.scenario.file import SCENARIOS_DIR
from auv_msgs.msg import FlockStatus, VehicleState
from auv_ros.wire import conversions as convert

pytestmark = pytest.mark.ros

PATIENCE_S = 120.0
FORGED_WORD = "forged"
FORGED = {
    "/auv_1/cmd_wrench": WrenchStamped(),
    "/auv_1/nav": VehicleState(tick=10**9, valid=True),
    "/flock/status": FlockStatus(state=FlockStatus.FINISHED, tick=10**6, time_s=2.6),
    "/clock": Clock(),
}


@pytest.fixture
def scenario_file(tmp_path):
    """Two vehicles of the main job."""
    raw = yaml.safe_load((SCENARIOS_DIR / "flock_acoustic.yaml").read_text())
    raw.update(name="pair", vehicles=raw["vehicles"][:2])
    path = tmp_path / "pair.yaml"
    path.write_text(yaml.safe_dump(raw))
    return path


def fly(scenario_file, name, *arguments):
    """Start a run whose results go to a folder."""
    command = [
        "auv_bringup.tools.run",
        scenario_file,
        "--no-figures",
        "--out",
        scenario_file.parent / name,
        *arguments,
    ]
    return subprocess.Popen(
        [sys.executable, "-m", *map(str, command)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**os.environ, "ROS_DOMAIN_ID": str(domain_id())},
    )


def finished(run):
    """Wait for the end of a run; return its status and its output."""
    try:
        said, _ = run.communicate(timeout=PATIENCE_S)
    finally:
        run.kill()
    return run.returncode, said


def results_of(scenario_file, name):
    (folder,) = (scenario_file.parent / name).iterdir()
    return folder, json.loads((folder / "provenance.json").read_text())


def forge_during(at, run):
    """Publish forged messages until a run is over."""
    publishers = [(at.stranger(type(message), topic), message) for topic, message in FORGED.items()]
    while run.poll() is None:
        for publisher, message in publishers:
            publisher.publish(message)
        at.executor.spin_once(timeout_sec=0.001)


@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
def test_a_flight_under_forged_messages_is_the_flight_without_them(scenario_file, mode):
    arguments = ("--mode", mode, "--layout", "single", "--duration", "20" if mode == "lockstep" else "6")
    with desk() as at:
        run = fly(scenario_file, "beside", *arguments)
        forge_during(at, run)
    status, said = finished(run)
    assert status == 0, said
    folder, provenance = results_of(scenario_file, "beside")
    assert provenance["simulated_s"] == pytest.approx(float(arguments[-1]), abs=0.5)
    assert "warning: /desk publishes /auv_1/nav: not heard" in said
    assert "incompatible QoS" not in said
    assert "/desk publishes /flock/status: not heard" in provenance["strangers"]
    assert "/flock/status: writers refused: 1" in provenance["strangers"]
    assert "/desk publishes" in (folder / "report.html").read_text()
    if mode == "lockstep":
        assert finished(fly(scenario_file, "alone", *arguments))[0] == 0
        alone, provenance = results_of(scenario_file, "alone")
        assert provenance["strangers"] == []
        assert compare_bags(folder / "bag", alone / "bag") == []


def is_running(status):
    return status.state == FlockStatus.RUNNING and status.detail != FORGED_WORD


def forge_ends_during(at, run, state):
    """Publish repeatedly, like the clock of a run, that a vehicle is lost and that the run is over."""
    publisher = at.publisher(FlockStatus, "/flock/status", latched=True)
    heard = at.listen(FlockStatus, "/flock/status", latched=True)
    said = 0
    while run.poll() is None:
        at.executor.spin_once(timeout_sec=0.02)
        running = next((each for each in reversed(heard) if is_running(each)), None)
        if running is None:
            continue
        heard.clear()
        running.lost_vehicles, running.detail = ["auv_2"], FORGED_WORD
        publisher.publish(running)
        left_s = running.duration_s - running.time_s
        stamp_s = running.header.stamp.sec + 1e-9 * running.header.stamp.nanosec + left_s
        publisher.publish(
            FlockStatus(
                header=convert.header(stamp_s, ""),
                state=state,
                time_s=running.duration_s,
                duration_s=running.duration_s,
                lost_vehicles=["auv_2"],
                detail=FORGED_WORD,
            )
        )
        said += 1
    return said


@pytest.mark.parametrize(
    ("state", "mode", "layout"),
    [
        (FlockStatus.FINISHED, "lockstep", "node"),
        pytest.param(FlockStatus.ABORTED, "lockstep", "single", marks=pytest.mark.slow),
        (FlockStatus.ABORTED, "realtime", "single"),
    ],
)
def test_a_forged_end_or_loss_ends_no_flight_and_no_process(scenario_file, state, mode, layout):
    duration_s = 80.0 if mode == "lockstep" else 5.0
    arguments: tuple[Any, ...] = ("--mode", mode, "--layout", layout, "--duration", duration_s)
    if layout == "node":
        arguments += ("--set", "on_vehicle_loss=continue")
    with desk() as at:
        run = fly(scenario_file, "beside", *arguments)
        forged = forge_ends_during(at, run, state)
    status, said = finished(run)
    assert forged > 3
    assert status == 0, said
    provenance = results_of(scenario_file, "beside")[1]
    assert provenance["simulated_s"] == pytest.approx(duration_s, abs=0.5)
    assert provenance["lost_vehicles"] == []
    assert said.count("auv_2 is lost, but the run's own clock goes on with it") == (layout == "node")
    assert said.count("the run's own process goes on: a foreign process publishes it; ignored") == 1


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("layout", ["node", "vehicle", "single"])
def test_a_reader_that_stalls_holds_no_flight(scenario_file, layout):
    run = fly(scenario_file, "beside", "--layout", layout, "--duration", "900")
    with process("auv_bringup.tools.topic", "--wait", 60, "hz", "/auv_1/state") as echo:
        assert echo.stdout.readline().startswith("average rate")
        os.kill(echo.pid, signal.SIGSTOP)
        status, said = finished(run)
    assert status == 0, said
    assert results_of(scenario_file, "beside")[1]["simulated_s"] == pytest.approx(900.0)
