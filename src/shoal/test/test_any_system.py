"""A run in one process asks the system for nothing that only Linux has, and for no ROS."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PACKAGES = sorted(
    path.parent for path in ROOT.glob("src/*/package.xml") if (path.parent / "setup.py").exists()
)
IN_THE_WHEEL = [path for path in PACKAGES if path.name != "auv_ros"]

NO_ROS = """
import sys
for name in ("rclpy", "auv_msgs", "auv_ros"):
    sys.modules[name] = None
"""
OTHER_SYSTEM = """
import ctypes, importlib.abc, multiprocessing, os, signal, sys

import numpy, psutil  # they know their systems themselves

for name in ("fcntl", "resource", "termios", "grp", "pwd", "rclpy", "auv_msgs", "auv_ros"):
    sys.modules[name] = None
for name in ("fork", "sched_getaffinity", "posix_fallocate", "killpg", "getsid", "setsid", "O_DIRECTORY"):
    delattr(os, name)
for name in ("SIGHUP", "pthread_sigmask"):
    delattr(signal, name)
"""


def run(program, folder, hidden=OTHER_SYSTEM):
    path = os.pathsep.join([*map(str, IN_THE_WHEEL), os.environ.get("PYTHONPATH", "")])
    return subprocess.run(
        [sys.executable, "-P", "-c", hidden + program],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": path, "SHOAL_PLUGINS": str(folder)},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )


def commands(folder, *calls, hidden=OTHER_SYSTEM):
    """Return exit status, output and error output of commands, called one after the other."""
    program = f"""
import contextlib, io, json
from shoal.commands import main
done = []
for words in {[call.split() for call in calls]!r}:
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err:
        try:
            status = main(words)
        except SystemExit as leaving:
            status = leaving.code
    done.append((status, out.getvalue(), err.getvalue()))
print(json.dumps(done))
"""
    done = run(program, folder, hidden)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_run_without_ros_is_flown_in_one_process_and_says_so(tmp_path):
    flight = "run flock_acoustic --duration 2 --no-figures --out out"
    flown, with_nodes, layout, again = commands(
        tmp_path,
        flight,
        f"{flight} --mode lockstep",
        f"{flight} --layout vehicle",
        "run --report out/flock_acoustic-1-inprocess-" + "x",
    )
    status, words, errors = flown
    assert (status, "Traceback" in errors) == (0, False), errors
    first, *_ = words.splitlines()
    assert first == "rclpy and auv_msgs cannot be imported: this run has no nodes (--mode inprocess)"
    (folder,) = (tmp_path / "out").iterdir()
    assert (folder / "recording.npz").is_file()
    assert with_nodes[0] == layout[0] == again[0] == 2
    assert with_nodes[2].startswith(
        "error: rclpy and auv_msgs cannot be imported, so no ROS 2 node can run; "
    )
    assert [each[2].count("\n") for each in (with_nodes, layout, again)] == [1, 1, 1]


STUDY = """
schema: 1
name: mine
title: mine
scenario: flock_acoustic
duration_s: 1.0
seeds: [1, 2]
metrics: [collision]
"""
CHAPTER = """
from auv_thesis.items import HOLDS, Claim, RunSpec, Verdict

TITLE = "Mine"
RUNS = (RunSpec("flock_acoustic", duration_s=1.0), RunSpec("no_such_scenario"))
CLAIMS = tuple(Claim("1", f"It flies {run}.", (run,), lambda runs: Verdict(HOLDS, "it did")) for run in RUNS)
"""


def test_a_sweep_and_the_reproduction_fly_without_processes_of_their_own(tmp_path):
    (tmp_path / "mine.yaml").write_text(STUDY)
    (tmp_path / "laws").mkdir()
    (tmp_path / "laws" / "mine.py").write_text(CHAPTER)
    listed, checked, flown, chapters, reproduced, refused = commands(
        tmp_path,
        "sweep --list",
        "sweep mine.yaml --check",
        "sweep mine.yaml --out swept",
        "reproduce --list",
        "reproduce --only mine --out reproduced",
        "sweep mine.yaml --workers 0",
    )
    assert [each[0] for each in (listed, checked, flown, chapters)] == [0, 0, 0, 0]
    assert "quick" in listed[1]
    assert (tmp_path / "swept" / "runs.parquet").is_file()
    assert "ch2" in chapters[1]
    assert reproduced[0] == 1
    assert "no_such_scenario" in (tmp_path / "reproduced" / "failures.txt").read_text()
    (kept,) = (tmp_path / "reproduced" / "runs").iterdir()
    assert (kept / "recording.npz").is_file()
    assert refused[0] == 2


@pytest.mark.parametrize("hidden", [OTHER_SYSTEM, NO_ROS], ids=["other system", "Linux"])
def test_what_needs_ros_is_refused_in_one_line(tmp_path, hidden):
    calls = (
        "replay bag",
        "topic list",
        "topic echo /clock",
        "replay --help",
        "topic --help",
        "topic",
        "fly",
        "",
    )
    done = commands(tmp_path, *calls, hidden=hidden)
    for status, words, errors in done[:3]:
        assert (status, words) == (2, "")
        assert re.fullmatch(r"error: shoal (replay|topic): rclpy cannot be imported; allowed: .*\n", errors)
    assert [status for status, _, _ in done[3:]] == [0, 0, 2, 2, 0]
    assert all(errors.count("\n") == 1 for status, _, errors in done if status == 2)


def test_the_python_interface_flies_draws_saves_opens_and_sweeps(tmp_path):
    program = """
import shoal
result = shoal.run("flock_acoustic", duration_s=2.0)
result.figure("pair_distances")
assert shoal.open(result.save("saved", with_figures=False)).metrics["collision"] is False
assert list(shoal.sweep("flock_acoustic", seeds=[1, 2], duration_s=1.0)["status"]) == ["done", "done"]
simulation = shoal.Simulation("flock_acoustic")
simulation.step()
print(simulation.time_s)
"""
    done = run(program, tmp_path)
    assert (done.returncode, done.stdout) == (0, "0.1\n"), done.stderr
