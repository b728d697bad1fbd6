"""The launcher with fake nodes that behave well or badly."""

import io
import os
import signal
import sys
import threading
import time
from pathlib import Path

import pytest

from auv_bringup.launching import status_listener, supervision
from auv_bringup.launching.launcher import fly_nodes
from auv_bringup.launching.layout import process_specs
from auv_bringup.launching.node_specs import node_specs
from auv_bringup.launching.node_start import node_environment
from auv_bringup.launching.status_listener import EAR, EAR_MODULE
from auv_core.cli.progress import Progress
from auv_core.machine import processes
from auv_core.machine.interrupts import Interrupts
from auv_core.machine.process_states import children_of
from auv_experiment.scenario.loading import load_scenario

pytestmark = pytest.mark.ros

LONG_S = 3000.0
FAKE_NODE = Path(__file__).with_name("fake_node.py")
RELAY, RECORDER = "/acoustic_relay_node", "/recorder_node"
AGENT_1, VEHICLE_1 = "/auv_1/agent_node", "/auv_1/vehicle_node"


HELD_EAR = """
import signal, time
signal.signal(signal.SIGINT, signal.SIG_IGN)
time.sleep(600)
"""


def is_alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def command_of(pid):
    return Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode()


class Stage:
    """A flight of fake nodes: two vehicles, relay and recorder."""

    def __init__(self, folder):
        self.folder = folder
        self.notes = folder / "notes"
        self.said = io.StringIO()
        self.interrupts = Interrupts()
        self.plan(2.0)

    def plan(self, duration_s):
        """Set the length of the flight."""
        self.duration_s = duration_s
        scenario = load_scenario("flock_acoustic", duration_s=duration_s)
        specs = node_specs(scenario, mode="lockstep", bag_dir=self.folder / "bag")
        wanted = [spec for spec in specs if spec.vehicle_id in ("", "auv_1", "auv_2")]
        self.specs = process_specs(wanted, "node")

    def fly(self, *, duration_s=2.0, policy="stop", **behaviours):
        """Fly with the behaviours given by role, or by full name with slashes left out."""
        self.plan(duration_s)
        environ = node_environment(
            os.environ, domain_id=int(os.environ.get("ROS_DOMAIN_ID") or 77), discovery="localhost"
        )
        # With a thread here the launcher's ear is no fork: of a process that has had nodes that would hang.
        over = threading.Event()
        threading.Thread(target=over.wait).start()
        try:
            with self.interrupts:
                self.flight = fly_nodes(
                    self.specs,
                    on_vehicle_loss=policy,
                    logs_dir=self.folder / "logs",
                    environ=environ,
                    interrupts=self.interrupts,
                    progress=Progress(2.0, self.said),
                    start=lambda children, process, parts, log, environ: children.start(
                        process.name, self.command(process, behaviours), log=log, environ=environ
                    ),
                )
        finally:
            over.set()
        assert [pid for pid in self.pids() if is_alive(pid)] == []
        return self.flight

    def command(self, spec, behaviours):
        by_name = behaviours.get(spec.name.strip("/").replace("/", "_"))
        behaviour = by_name or behaviours.get(spec.role) or ("fly" if spec.role == "relay" else "idle")
        return [sys.executable, str(FAKE_NODE), str(self.notes), spec.name, behaviour, str(self.duration_s)]

    def pids(self):
        logs = [path.read_text() for path in (self.folder / "logs").glob("*.log")]
        return [int(text.split(" with pid ")[1].split()[0]) for text in logs if " with pid " in text]

    def happened(self, word):
        """Return the names of the nodes to which it happened, in order."""
        lines = self.notes.read_text().splitlines() if self.notes.exists() else []
        return [line.split()[1] for line in lines if line.startswith(word)]

    def when(self, condition, action):
        """Do something as soon as a condition holds, in a thread."""

        def watch():
            pause, deadline_s = threading.Event(), time.monotonic() + 60.0
            while not condition() and time.monotonic() < deadline_s:
                pause.wait(0.01)
            action()

        threading.Thread(target=watch, daemon=True).start()

    @property
    def is_up(self):
        return len(self.happened("started")) == len(self.specs) and "all nodes are up" in self.said.getvalue()


@pytest.fixture
def stage(tmp_path):
    return Stage(tmp_path)


def test_a_flight_ends_in_order_and_the_recorder_last(stage):
    flight = stage.fly()
    assert (flight.exit_status, flight.reason, flight.lost_vehicles) == (0, "", ())
    assert flight.simulated_s == pytest.approx(2.0)
    assert 0.5 < flight.real_time_factor < 3.0
    ended = stage.happened("ended")
    assert sorted(ended) == sorted(spec.name for spec in stage.specs)
    assert ended[-1] == RECORDER


def test_every_node_has_a_log_and_a_parameters_file(stage):
    stage.fly()
    logs = stage.folder / "logs"
    nodes = {path.stem for path in (logs / "params").iterdir()}
    assert {path.stem for path in logs.glob("*.log")} == nodes | {"_shoal_launcher"}
    assert (logs / "auv_1.agent_node.log").read_text().startswith(AGENT_1)


@pytest.mark.parametrize("role", ["relay", "recorder"])
def test_without_relay_or_recorder_the_flight_stops_whatever_the_scenario_says(stage, role):
    flight = stage.fly(policy="continue", duration_s=LONG_S, **{role: "die"})
    assert flight.exit_status == 3
    assert (RELAY if role == "relay" else RECORDER) in flight.reason


def test_a_node_that_dies_is_named_with_its_last_words_and_stops_the_flight(stage):
    flight = stage.fly(duration_s=LONG_S, auv_1_agent_node="die")
    assert flight.exit_status == 3
    assert AGENT_1 in flight.reason
    said = stage.said.getvalue()
    assert f"{AGENT_1} has ended early: exit status 7" in said
    assert "something is wrong" in said


def test_a_killed_node_is_named_within_5_s(stage):
    killed_at_s = []

    def kill():
        log = (stage.folder / "logs" / "auv_1.vehicle_node.log").read_text()
        os.kill(int(log.split(" with pid ")[1].split()[0]), signal.SIGKILL)
        killed_at_s.append(time.monotonic())

    stage.when(lambda: stage.is_up, kill)
    flight = stage.fly(duration_s=LONG_S)
    assert flight.exit_status == 3
    assert f"{VEHICLE_1} has ended early (killed by SIGKILL)" in flight.reason
    assert time.monotonic() - killed_at_s[0] < 10.0  # all the ending is in it


def test_a_flight_may_go_on_without_a_vehicle(stage):
    flight = stage.fly(policy="continue", duration_s=4.0, auv_1_agent_node="die")
    assert (flight.exit_status, flight.lost_vehicles) == (0, ("auv_1",))
    assert "goes on without it" in stage.said.getvalue()
    assert VEHICLE_1 not in stage.happened("ended")  # its computer is gone at once, as that of a lost vehicle
    assert stage.happened("ended")[-1] == RECORDER


def test_a_vehicle_that_the_clock_gives_up_loses_its_processes(stage):
    flight = stage.fly(policy="continue", duration_s=4.0, relay="lose", auv_2_agent_node="stubborn")
    assert (flight.exit_status, flight.lost_vehicles) == (0, ("auv_2",))


def test_a_flight_that_the_clock_ends_says_why(stage):
    flight = stage.fly(relay="abort")
    assert flight.exit_status == 3
    assert f"{AGENT_1}: no answer" in flight.reason


def test_a_clock_that_leaves_early_is_named(stage):
    flight = stage.fly(relay="leave")
    assert flight.exit_status == 3
    assert RELAY in flight.reason


def test_a_frozen_clock_is_named_within_5_s(stage):
    frozen_at_s = []

    def freeze():
        log = (stage.folder / "logs" / "acoustic_relay_node.log").read_text()
        os.kill(int(log.split(" with pid ")[1].split()[0]), signal.SIGSTOP)
        frozen_at_s.append(time.monotonic())

    named_at_s = []
    stop = supervision.Supervisor._stop

    def noted_stop(supervisor, reason):
        named_at_s.append(time.monotonic())
        stop(supervisor, reason)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(supervision.Supervisor, "_stop", noted_stop)
        patch.setattr(processes, "SIGTERM_GRACE_S", 0.5)
        stage.when(lambda: stage.is_up, freeze)
        flight = stage.fly(duration_s=LONG_S)
    assert flight.exit_status == 3
    assert "/clock_node" in flight.reason
    assert named_at_s[0] - frozen_at_s[0] < 5.0


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_an_ear_that_is_killed_or_stopped_is_named_and_holds_no_end(stage, number):
    def hit():
        (pid,) = [pid for pid in children_of(os.getpid()) if EAR_MODULE in command_of(pid)]
        os.kill(pid, number)

    stage.when(lambda: stage.is_up, hit)
    flight = stage.fly(duration_s=LONG_S)
    assert flight.exit_status == 3
    assert flight.reason.startswith(EAR.name)


def test_an_ear_that_the_middleware_holds_does_not_hold_the_launcher(stage, monkeypatch, tmp_path):
    (tmp_path / "held.py").write_text(HELD_EAR)
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}:{os.environ['PYTHONPATH']}")
    monkeypatch.setattr(status_listener, "EAR_MODULE", "held")
    flight = stage.fly(duration_s=LONG_S, auv_1_agent_node="die")
    assert flight.exit_status == 3
    assert flight.reason.startswith(AGENT_1)


def test_silence_from_the_start_ends_the_wait(stage, monkeypatch):
    monkeypatch.setattr(supervision, "NO_STATUS_S", 2.0)
    flight = stage.fly(relay="idle")
    assert flight.exit_status == 3
    assert "no status from /clock_node" in flight.reason


def test_processes_of_a_lost_run_are_told_soon_to_wait_for_nobody(stage, monkeypatch):
    monkeypatch.setattr("auv_bringup.launching.launcher.SIGINT_GRACE_S", 100.0)
    monkeypatch.setattr("auv_bringup.launching.launcher.RECORDER_GRACE_S", 100.0)
    lost_at_s = []
    stop = supervision.Supervisor._stop

    def noted_stop(supervisor, reason):
        lost_at_s.append(time.monotonic())
        stop(supervisor, reason)

    monkeypatch.setattr(supervision.Supervisor, "_stop", noted_stop)
    flight = stage.fly(relay="abort", agent="hand_over", recorder="hand_over")
    assert flight.exit_status == 3
    assert time.monotonic() - lost_at_s[0] < 60.0
    assert stage.happened("ended")[-1] == RECORDER
    assert "did not end cleanly" not in stage.said.getvalue()


def interrupt(stage, count=1):
    def send():
        for number in range(count):
            os.kill(os.getpid(), signal.SIGINT)
            pause = threading.Event()
            while stage.interrupts.count <= number:
                pause.wait(0.001)

    return send


def test_ctrl_c_ends_everything_in_order(stage):
    stage.when(lambda: stage.is_up, interrupt(stage))
    flight = stage.fly(duration_s=LONG_S)
    assert flight.exit_status == 130
    assert flight.reason.startswith("interrupted at")
    ended = stage.happened("ended")
    assert sorted(ended) == sorted(spec.name for spec in stage.specs)
    assert ended[-1] == RECORDER


def test_ctrl_c_during_the_start_leaves_nothing(stage):
    stage.when(lambda: stage.happened("started"), interrupt(stage))
    assert stage.fly(relay="idle").exit_status == 130


def test_ctrl_c_twice_hurries_stubborn_nodes(stage):
    start_s = []

    def send():
        start_s.append(time.monotonic())
        interrupt(stage, count=2)()

    stage.when(lambda: stage.is_up, send)
    flight = stage.fly(duration_s=LONG_S, auv_1_agent_node="stubborn", recorder="stubborn")
    assert flight.exit_status == 130
    assert time.monotonic() - start_s[0] < 4 * processes.HURRY_GRACE_S + 4.0
    assert "did not end cleanly: killed by SIGKILL" in stage.said.getvalue()


def test_a_recorder_that_does_not_close_its_bag_spoils_the_flight(stage, monkeypatch):
    monkeypatch.setattr("auv_bringup.launching.launcher.RECORDER_GRACE_S", 0.3)
    monkeypatch.setattr(processes, "SIGTERM_GRACE_S", 0.3)
    flight = stage.fly(recorder="stubborn")
    assert flight.exit_status == 3
    assert "did not close its bag" in flight.reason
