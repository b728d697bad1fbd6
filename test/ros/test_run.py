"""The run command with its real nodes: complete flights, and flights that a user or a signal ends."""

import contextlib
import fcntl
import json
import os
import pty
import select
import shutil
import signal
import subprocess
import sys
import termios
import threading
import time
from pathlib import Path
from typing import Any

import pytest
import yaml

from auv_bag.bag import Bag
from auv_bringup.launching import launcher
from auv_bringup.tools.run import main
from auv_core.machine.process_states import children_of
from auv_experiment.recording_from_bag import read_recording
from auv_experiment.scenario.file import SCENARIOS_DIR
from auv_experiment.scenario.loading import load_scenario

pytestmark = pytest.mark.ros

PATIENCE_S = 120.0
WORK_JIFFIES = 20
RECORDED_BYTES = 300_000
"""More than the definitions at the head of a bag: chunks of the flight are on disk."""
NODES = [
    "_shoal_launcher",
    "acoustic_relay_node",
    "auv_1.agent_node",
    "auv_1.vehicle_node",
    "auv_2.agent_node",
    "auv_2.vehicle_node",
]


FAILING_LAW = """
from dataclasses import dataclass

@dataclass(frozen=True)
class Params:
    pass

class Separation:
    calls = 0

    def __init__(self, params):
        pass

    def velocity(self, own, other, spacing_m):
        Separation.calls += 1
        if Separation.calls > 40:
            raise RuntimeError("no law today")
        return (0.0, 0.0, 0.0)
"""


@pytest.fixture
def scenario_file(tmp_path):
    """Two kinematic vehicles, long enough to be interrupted."""
    raw = yaml.safe_load((SCENARIOS_DIR / "ch5_four_leaders.yaml").read_text())
    raw.update(name="pair", sampling="sampled", duration_s=2000.0, vehicles=raw["vehicles"][:2])
    raw["leaders"] = [vehicle["id"] for vehicle in raw["vehicles"]]
    path = tmp_path / "pair.yaml"
    path.write_text(yaml.safe_dump(raw))
    return path


class Run:
    """A run command that is under way."""

    def __init__(self, scenario_file, *arguments):
        self.out = scenario_file.parent / "results"
        self.options = ("--no-figures", "--out", str(self.out))
        self.errors = scenario_file.parent / f"stderr-{time.monotonic_ns()}.txt"
        with self.errors.open("wb") as stream:
            self.process = subprocess.Popen(
                [
                    sys.executable,
                    "-m",
                    "auv_bringup.tools.run",
                    str(scenario_file),
                    *arguments,
                    *self.options,
                ],
                stdout=subprocess.PIPE,
                stderr=stream,
                text=True,
            )
        self.watches = {}

    def wait_until_up(self, recorded_bytes=0):
        """Wait until the flight has begun and so much is on disk, and keep an eye on every process."""
        pause, deadline_s = threading.Event(), time.monotonic() + PATIENCE_S
        while "all nodes are up" not in self.errors.read_text() or self.recorded_bytes < recorded_bytes:
            assert time.monotonic() < deadline_s, self.errors.read_text()
            assert self.process.poll() is None, self.errors.read_text()
            pause.wait(0.02)
        self.watches = {pid: os.pidfd_open(pid) for pid in descendants_of(self.process.pid)}
        done = self.worked_jiffies + WORK_JIFFIES
        while self.worked_jiffies < done:
            assert time.monotonic() < deadline_s, self.errors.read_text()
            assert self.process.poll() is None, self.errors.read_text()
            pause.wait(0.02)
        return self

    @property
    def worked_jiffies(self):
        """Processor time of the processes that live: it grows by some ticks of flight for each jiffy."""
        worked = 0
        for pid in self.watches:
            with contextlib.suppress(OSError):
                words = stat_of(pid)
                worked += int(words[11]) + int(words[12])
        return worked

    def wait_for_word(self, word):
        pause, deadline_s = threading.Event(), time.monotonic() + PATIENCE_S
        while word not in self.errors.read_text():
            assert time.monotonic() < deadline_s, self.errors.read_text()
            pause.wait(0.01)

    @property
    def recorded_bytes(self):
        return sum(path.stat().st_size for path in (self.folder / "bag").glob("*.mcap"))

    def node(self, part):
        """Return the process id of the node whose command line has a word in it."""
        (pid,) = [pid for pid in self.watches if part in command_of(pid)]
        return pid

    def wait(self):
        """Wait for the end; return status, output and errors. No process outlives the command."""
        output, _ = self.process.communicate(timeout=PATIENCE_S)
        for pid, watch in self.watches.items():
            assert select.select([watch], [], [], 10.0)[0], f"{pid} is still there"
        return self.process.returncode, output, self.errors.read_text()

    @property
    def folder(self):
        (folder,) = self.out.iterdir()
        return folder

    def close(self):
        for watch in self.watches.values():
            os.close(watch)
        if self.process.poll() is None:
            self.process.kill()
            self.process.communicate()


@pytest.fixture
def start(scenario_file):
    runs = []

    def begin(*arguments):
        runs.append(Run(scenario_file, *arguments))
        return runs[-1]

    yield begin
    for run in runs:
        run.close()


def stat_of(pid):
    """Return the fields of a process in /proc that follow its name: state, parent, ..."""
    return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()


def descendants_of(parent):
    found = []
    for entry in Path("/proc").iterdir():
        with contextlib.suppress(OSError, ValueError):
            if int(stat_of(entry.name)[1]) == parent:
                found += [int(entry.name), *descendants_of(int(entry.name))]
    return found


def command_of(pid):
    return (Path("/proc") / str(pid) / "cmdline").read_bytes().replace(b"\0", b" ").decode()


def recorded_s(run):
    """Return how much of the flight the bag holds (s)."""
    recording = read_recording(run.folder / "bag", load_scenario(str(run.folder / "scenario.yaml")))
    return recording.t_s[-1]


def test_ctrl_c_ends_a_run_that_still_compiles(scenario_file, monkeypatch, capsys, keep_signal_handlers):
    def compile_long(*_):
        os.kill(os.getpid(), signal.SIGINT)
        threading.Event().wait(PATIENCE_S)

    monkeypatch.setattr(launcher, "threads_allow_fork", lambda: True)
    monkeypatch.setattr(launcher, "compile_ahead", compile_long)
    out = scenario_file.parent / "results"
    assert main([str(scenario_file), "--out", str(out)]) == 130
    assert capsys.readouterr().err.endswith("error: interrupted before anything was recorded\n")
    assert list(out.iterdir()) == []


def test_a_flight_from_start_to_report(start):
    run = start("--duration", "5", "--seed", "3")
    status, output, errors = run.wait()
    assert status == 0, errors
    assert run.folder.name.startswith("pair-3-lockstep-")
    for name in ("scenario.yaml", "provenance.json", "metrics.json", "report.html", "bag/metadata.yaml"):
        assert (run.folder / name).is_file(), name
    logs = sorted((run.folder / "logs").glob("*.log"))
    assert [path.stem for path in logs] == [*NODES, "recorder_node"]
    assert not any("XML" in path.read_text() for path in logs), "Fast DDS refuses its profiles"
    assert output.splitlines()[-1] == f"report: {run.folder / 'report.html'}"
    assert "export ROS_DOMAIN_ID=" in output
    assert "ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST" in output
    assert "Traceback" not in errors
    assert "warning" not in errors
    assert recorded_s(run) == pytest.approx(5.0)
    assert json.loads((run.folder / "metrics.json").read_text())["duration_s"] == pytest.approx(5.0)


def test_without_a_bag_there_is_no_recorder_and_it_is_said(start):
    run = start("--duration", "2", "--no-bag")
    status, output, errors = run.wait()
    assert status == 0, errors
    assert "nothing was recorded" in output
    assert sorted(path.stem for path in (run.folder / "logs").glob("*.log")) == NODES


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_flight_ends_everything_and_leaves_a_readable_bag(start, number):
    run = start().wait_until_up()
    asked_at_s = time.monotonic()
    run.process.send_signal(number)
    status, _, errors = run.wait()
    assert status == 130, errors
    assert time.monotonic() - asked_at_s < 30.0
    assert f"--report {run.folder}" in errors
    assert "Traceback" not in errors
    assert (run.folder / "bag" / "metadata.yaml").is_file()
    assert recorded_s(run) > 0.0


def test_a_killed_node_is_named_and_stops_the_flight(start):
    run = start().wait_until_up()
    killed_at_s = time.monotonic()
    os.kill(run.node("auv_2.agent_node"), signal.SIGKILL)
    run.wait_for_word("/auv_2/agent_node")
    assert time.monotonic() - killed_at_s < 5.0
    status, _, errors = run.wait()
    assert status == 3
    assert "/auv_2/agent_node has ended early: killed by SIGKILL" in errors
    assert (run.folder / "metrics.json").is_file()


def stop_while_it_starts(run):
    """Stop an agent as soon as its process is there; return the status and the errors of the run."""
    pause, deadline_s = threading.Event(), time.monotonic() + PATIENCE_S
    agents: list[Any] = []
    while not agents:
        assert time.monotonic() < deadline_s
        pause.wait(0.001)
        with contextlib.suppress(OSError):
            nodes = children_of(run.process.pid)
            agents = [pid for pid in nodes if "agent_node /auv_2" in command_of(pid)]
    os.kill(agents[0], signal.SIGSTOP)
    status, _, errors = run.wait()
    return status, errors


def test_an_agent_that_is_stopped_while_the_flight_starts_is_one_line(start):
    for _ in range(5):
        run = start()
        status, errors = stop_while_it_starts(run)
        assert status == 3
        if "all nodes are up" not in errors:
            break
        shutil.rmtree(run.out)  # the flight was quicker
    (line,) = [line for line in errors.splitlines() if line.startswith(("error", "warning"))]
    assert line.startswith("error: /auv_2/agent_node is stopped by a signal; ")
    assert "nothing to report on: " in line
    assert line.endswith(f"logs are in {run.folder / 'logs'}")


def test_a_frozen_node_is_named_and_stops_the_flight(start):
    run = start().wait_until_up()
    frozen_at_s = time.monotonic()
    os.kill(run.node("auv_2.agent_node"), signal.SIGSTOP)
    run.wait_for_word("/auv_2/agent_node")
    assert time.monotonic() - frozen_at_s < 5.0
    status, _, errors = run.wait()
    assert status == 3
    assert "/auv_2/agent_node" in errors.splitlines()[-1]


@pytest.mark.parametrize("layout", ["node", pytest.param("vehicle", marks=pytest.mark.slow)])
def test_a_flight_goes_on_without_a_killed_vehicle(start, layout):
    run = start("--set", "on_vehicle_loss=continue", "--duration", "150", "--layout", layout).wait_until_up()
    os.kill(run.node("auv_2.agent_node"), signal.SIGKILL)
    status, output, errors = run.wait()
    metrics = json.loads((run.folder / "metrics.json").read_text())
    assert status == (4 if metrics["collision"] else 0), errors  # the other may run into what drifts
    assert "auv_2 is lost" in errors
    assert "lost vehicles: auv_2" in output
    assert metrics["lost_vehicles"] == ["auv_2"]
    assert metrics["duration_s"] == pytest.approx(150.0)


def test_a_node_that_raises_in_a_process_of_all_nodes_is_named_in_one_line(start, monkeypatch, tmp_path):
    law = tmp_path / "plugins" / "separation" / "failing.py"
    law.parent.mkdir(parents=True)
    law.write_text(FAILING_LAW)
    monkeypatch.setenv("SHOAL_PLUGINS", str(tmp_path / "plugins"))
    run = start("--set", "agent.separation.kind=failing", "--duration", "60", "--layout", "single")
    status, _, errors = run.wait()
    assert status == 3
    said = "/node_container has ended early (exit status 1): /auv_1/agent_node: RuntimeError: no law today; "
    assert errors.splitlines()[-1].startswith(f"error: {said}")
    assert (run.folder / "metrics.json").is_file()
    assert recorded_s(run) > 1.5


def test_a_run_may_have_few_processes_and_none_interrupts_another(start):
    run = start("--layout", "vehicle").wait_until_up()
    assert len(run.watches) == 6  # with the launcher's ear and the one that writes the bag
    threads = [int(path.name) for pid in run.watches for path in Path(f"/proc/{pid}/task").iterdir()]
    assert {os.sched_getscheduler(thread) for thread in threads} == {os.SCHED_BATCH}
    run.process.send_signal(signal.SIGINT)
    assert run.wait()[0] == 130
    assert recorded_s(run) > 0.0


def test_nodes_die_with_a_killed_launcher(start):
    run = start().wait_until_up(RECORDED_BYTES)
    assert len(run.watches) == 8
    run.process.kill()
    run.wait()
    assert Bag(run.folder).complete
    assert recorded_s(run) > 0.0


@pytest.mark.alone
def test_a_second_run_beside_takes_another_domain(start):
    first = start().wait_until_up()
    second = start("--duration", "1")
    status, output, errors = second.wait()
    assert status == 0, errors
    asked = int(os.environ.get("ROS_DOMAIN_ID") or 0)
    assert f"ROS domain {asked} is in use" in output
    assert f"export ROS_DOMAIN_ID={asked} " not in output
    first.process.send_signal(signal.SIGINT)
    assert first.wait()[0] == 130


@pytest.mark.parametrize("layout", ["node", "single"])
def test_a_closed_terminal_ends_the_run_in_order_and_leaves_its_status(scenario_file, layout):
    out = scenario_file.parent / "results"
    words = [
        sys.executable,
        "-m",
        "auv_bringup.tools.run",
        str(scenario_file),
        "--layout",
        layout,
        "--out",
        str(out),
    ]
    terminal, slave = pty.openpty()
    process = subprocess.Popen(
        words,
        stdin=slave,
        stdout=slave,
        stderr=slave,
        start_new_session=True,
        preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
    )
    os.close(slave)
    said = b""
    try:
        while b"nodes are up" not in said:
            assert select.select([terminal], [], [], PATIENCE_S)[0], said
            said += os.read(terminal, 4096)
        os.close(terminal)  # the kernel sends SIGHUP, and every write fails from now on
        assert process.wait(PATIENCE_S) == 130
    finally:
        process.kill()
        process.wait()
    (folder,) = out.iterdir()
    known = json.loads((folder / "provenance.json").read_text())
    assert known["exit_status"] == 130
    assert known["stopped_because"].startswith("interrupted at")
    assert Bag(folder).complete


def test_results_that_are_moved_in_flight_are_one_line_at_its_end(start):
    run = start().wait_until_up()
    run.out.rename(run.out.with_name("elsewhere"))
    run.process.send_signal(signal.SIGINT)
    status, _, errors = run.wait()
    assert status == 3
    assert "provenance.json: its folder is gone: it was moved or removed" in errors.splitlines()[-1]
    assert "Traceback" not in errors
    assert not run.out.exists()


def test_a_stopped_writer_of_the_bag_is_named_and_does_not_hold_the_end(start):
    run = start("--layout", "single").wait_until_up(RECORDED_BYTES)
    stopped_at_s = time.monotonic()
    os.kill(run.node("auv_bag.process"), signal.SIGSTOP)
    run.wait_for_word("auv_bag.process, started by /node_container, is stopped by a signal")
    assert time.monotonic() - stopped_at_s < 5.0
    status, _, errors = run.wait()
    assert time.monotonic() - stopped_at_s < 20.0  # 38 s before
    assert status == 3
    assert "bag_0.mcap was killed before it finished; the file is repaired" in errors
    assert Bag(run.folder).complete
    assert recorded_s(run) > 0.0


def shared_memory_of(pids):
    """Return device and inode of every file of Fast DDS that processes have mapped."""
    found = set()
    for pid in pids:
        for line in Path(f"/proc/{pid}/maps").read_text().splitlines():
            if "/dev/shm/fast" in line and not line.endswith("(deleted)"):
                found.add(line.split()[4])
    return found


def in_shared_memory():
    return {str(path.stat().st_ino) for path in Path("/dev/shm").iterdir() if path.name.startswith("fast")}


@pytest.mark.alone
@pytest.mark.slow
def test_a_run_with_a_killed_node_leaves_nothing_in_shared_memory(start):
    run = start().wait_until_up()
    files = shared_memory_of(run.watches)
    assert files & in_shared_memory()
    os.kill(run.node("auv_1.vehicle_node"), signal.SIGKILL)
    run.wait()
    assert files & in_shared_memory() == set()


@pytest.mark.alone
def test_the_next_run_clears_what_a_killed_launcher_leaves_in_shared_memory(start):
    run = start("--layout", "single").wait_until_up()
    files = shared_memory_of(run.watches)
    run.process.kill()
    run.wait()
    assert files & in_shared_memory()
    assert start("--layout", "single", "--duration", "1", "--no-bag").wait()[0] == 0
    assert files & in_shared_memory() == set()


def test_a_flight_under_nohup_goes_on(start):
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        run = start("--layout", "single").wait_until_up()
    finally:
        signal.signal(signal.SIGHUP, before)
    run.process.send_signal(signal.SIGHUP)
    size = run.recorded_bytes
    pause, deadline_s = threading.Event(), time.monotonic() + PATIENCE_S
    while run.recorded_bytes < size + 100_000:
        assert run.process.poll() is None, run.errors.read_text()
        assert time.monotonic() < deadline_s
        pause.wait(0.05)
    assert "ending the run" not in run.errors.read_text()
    run.process.send_signal(signal.SIGINT)
    assert run.wait()[0] == 130
