"""Real child processes: cooperative and stubborn ones, and their end when the parent is killed."""

import os
import select
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from auv_core.machine import processes
from auv_core.machine.child_end import last_lines
from auv_core.machine.processes import ChildProcesses

PATIENCE_S = 20.0

GOOD = """
import signal
signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
print('ready', flush=True)
signal.sigwait([signal.SIGINT])
print('bye')
"""
DEFAULT = "import time; print('ready', flush=True); time.sleep(100)"
NO_SIGINT = """
import signal, time
signal.signal(signal.SIGINT, signal.SIG_IGN)
print('ready', flush=True)
time.sleep(100)
"""
SLOW = """
import signal, time
for number in (signal.SIGINT, signal.SIGTERM):
    signal.pthread_sigmask(signal.SIG_BLOCK, [number])
print('ready', flush=True)
for number in (signal.SIGINT, signal.SIGTERM):
    signal.sigwait([number])
time.sleep(2.5)  # longer than children have by default after SIGTERM
print('bye')
"""
STUBBORN = NO_SIGINT.replace("print", "signal.signal(signal.SIGTERM, signal.SIG_IGN)\nprint")
PARENT = """
import os, sys
from pathlib import Path
from auv_core.machine.processes import ChildProcesses
children = ChildProcesses()
command = [sys.executable, "-c", sys.argv[1]]
for name in ("a", "b"):
    children.start(name, command, log=Path(sys.argv[2]) / name, environ=os.environ)
print(children.pid("a"), children.pid("b"), flush=True)
sys.stdin.read()
"""


def wait_until(condition, patience_s=PATIENCE_S):
    """Wait until a condition holds, and fail if it takes too long."""
    pause = threading.Event()
    deadline_s = time.monotonic() + patience_s
    while not condition():
        assert time.monotonic() < deadline_s, "waited too long"
        pause.wait(0.005)


@contextmanager
def family(tmp_path, **scripts):
    """Children by name, each ready."""
    with ChildProcesses() as children:
        for name, script in scripts.items():
            children.start(
                name, [sys.executable, "-c", script], log=tmp_path / f"{name}.log", environ=os.environ
            )
        wait_until(lambda: all("ready" in (tmp_path / f"{name}.log").read_text() for name in scripts))
        yield children


@pytest.fixture
def short_graces(monkeypatch):
    monkeypatch.setattr(processes, "SIGTERM_GRACE_S", 0.3)
    return 0.3


def test_a_child_that_ends_by_itself_is_collected_once(tmp_path):
    with ChildProcesses() as children:
        script = [sys.executable, "-c", "import sys; print('last words'); sys.exit(5)"]
        children.start("short", script, log=tmp_path / "log", environ=os.environ)
        exits: list[Any] = []

        def has_ended():
            exits.extend(children.collect_exits())
            return exits

        wait_until(has_ended)
        assert [(exit_.name, exit_.returncode, exit_.words) for exit_ in exits] == [
            ("short", 5, "exit status 5")
        ]
        assert children.collect_exits() == []
        assert children.running == []
        assert last_lines(children.log("short")) == ["last words"]


def test_children_end_cleanly_on_sigint(tmp_path):
    with family(tmp_path, a=GOOD, b=GOOD) as children:
        exits = children.end(["a", "b"])
        assert [(exit_.name, exit_.returncode) for exit_ in exits] == [("a", 0), ("b", 0)]
        assert last_lines(tmp_path / "a.log") == ["ready", "bye"]


def test_a_child_deaf_to_sigint_gets_sigterm(tmp_path):
    with family(tmp_path, deaf=NO_SIGINT) as children:
        (exit_,) = children.end(["deaf"], grace_s=0.2)
        assert exit_.words == "killed by SIGTERM"


def test_children_that_shall_wait_for_nobody_get_sigterm_early_and_then_the_whole_grace(tmp_path):
    with family(tmp_path, slow=SLOW) as children:
        (exit_,) = children.end(["slow"], grace_s=PATIENCE_S, sigterm_after_s=0.1)
        assert exit_.words == "exit status 0"
        assert last_lines(tmp_path / "slow.log") == ["ready", "bye"]


def test_a_stubborn_child_is_killed_and_others_are_not_kept_waiting(tmp_path, short_graces):
    with family(tmp_path, stubborn=STUBBORN, good=GOOD) as children:
        exits = {
            exit_.name: exit_.words for exit_ in children.end(["stubborn", "good"], grace_s=short_graces)
        }
        assert exits == {"stubborn": "killed by SIGKILL", "good": "exit status 0"}
        assert children.running == []


def test_a_stopped_child_is_seen_and_ended_at_once(tmp_path):
    with family(tmp_path, good=GOOD, stopped=GOOD) as children:
        assert children.stopped() == {}
        os.kill(children.pid("stopped"), signal.SIGSTOP)
        wait_until(lambda: children.stopped() == {"stopped": ""})
        start_s = time.monotonic()
        exits = {each.name: each.returncode for each in children.end(["good", "stopped"])}
    assert exits == {"good": 0, "stopped": -signal.SIGKILL}
    assert time.monotonic() - start_s < 3.0


WITH_GRANDCHILD = """
import subprocess, sys, time
grandchild = subprocess.Popen([sys.executable, "-c", {script!r}],
                              start_new_session=True)
print(grandchild.pid, 'ready', flush=True)
time.sleep(100)
"""


def grandchild_of(tmp_path, name):
    return int((tmp_path / f"{name}.log").read_text().split(" ready")[0].split()[-1])


def test_a_stopped_grandchild_is_seen_with_its_parent_and_killed(tmp_path):
    script = WITH_GRANDCHILD.format(script="import time; time.sleep(100)")
    with family(tmp_path, parent=script) as children:
        pid = grandchild_of(tmp_path, "parent")
        os.kill(pid, signal.SIGSTOP)
        wait_until(lambda: children.stopped() == {"parent": sys.executable})
        children.end(["parent"])
        assert children.end_orphans(grace_s=5.0) == []
        assert not Path(f"/proc/{pid}").exists()


@pytest.mark.parametrize(
    ("script", "grace_s", "is_killed"), [("pass", 5.0, False), ("time.sleep(100)", 0.2, True)]
)
def test_what_an_ended_child_leaves_is_waited_for_and_killed_by_its_id(tmp_path, script, grace_s, is_killed):
    lasting = f"import time; time.sleep(0.3); {script}"
    with family(tmp_path, parent=WITH_GRANDCHILD.format(script=lasting)) as children:
        pid = grandchild_of(tmp_path, "parent")
        children.kill(["parent"])
        assert children.end_orphans(grace_s=grace_s) == ([pid] if is_killed else [])
        assert not Path(f"/proc/{pid}").exists()


def test_processes_of_others_are_not_orphans(tmp_path):
    other = subprocess.Popen(
        [sys.executable, "-c", DEFAULT], start_new_session=True, stdout=subprocess.DEVNULL
    )
    try:
        with family(tmp_path, good=GOOD) as children:
            children.end(["good"])
            assert children.end_orphans(grace_s=0.0) == []
        assert other.poll() is None
    finally:
        other.kill()
        other.wait(10)


def test_hurry_cuts_the_grace_short(tmp_path, monkeypatch):
    monkeypatch.setattr(processes, "HURRY_GRACE_S", 0.1)
    with family(tmp_path, stubborn=STUBBORN) as children:
        start_s = time.monotonic()
        children.end(["stubborn"], grace_s=100.0, is_hurried=lambda: True)
        assert time.monotonic() - start_s < 10.0


def test_leaving_kills_what_still_runs(tmp_path):
    with family(tmp_path, stubborn=STUBBORN) as children:
        watch = os.pidfd_open(children.pid("stubborn"))
    assert select.select([watch], [], [], PATIENCE_S)[0]
    os.close(watch)


def test_a_child_leads_its_own_session(tmp_path):
    with family(tmp_path, a=DEFAULT) as children:
        pid = children.pid("a")
        assert os.getsid(pid) == os.getpgid(pid) == pid != os.getsid(0)


def test_a_child_hears_sigint_even_if_its_parent_ignores_it(tmp_path):
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with family(tmp_path, a=DEFAULT) as children:
            (exit_,) = children.end(["a"])
            assert exit_.returncode in (-signal.SIGINT, 1)
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSEGV])
def test_children_die_with_their_parent(tmp_path, number):
    environ = {**os.environ, "PYTHONPATH": str(Path(processes.__file__).parents[2])}
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT, STUBBORN, str(tmp_path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=environ,
    )
    assert parent.stdout is not None
    watches = [os.pidfd_open(int(pid)) for pid in parent.stdout.readline().split()]
    try:
        wait_until(lambda: all("ready" in (tmp_path / name).read_text() for name in ("a", "b")))
        parent.send_signal(number)
        parent.communicate(timeout=PATIENCE_S)
        for watch in watches:
            assert select.select([watch], [], [], PATIENCE_S)[0], "a child outlived its parent"
    finally:
        for watch in watches:
            os.close(watch)
