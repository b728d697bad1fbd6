"""A run in one process asks the system for nothing that only Linux has, and for no ROS."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[3]
PACKAGES = sorted(
    path.parent for path in ROOT.glob("src/*/package.xml") if (path.parent / "setup.py").exists()
)
IN_THE_WHEEL = [path for path in PACKAGES if path.name != "auv_ros"]

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


def run(program, folder):
    path = os.pathsep.join([*map(str, IN_THE_WHEEL), os.environ.get("PYTHONPATH", "")])
    return subprocess.run(
        [sys.executable, "-P", "-c", OTHER_SYSTEM + program],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": path},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )


def test_the_command_flies_in_one_process(tmp_path):
    words = [
        "run",
        "flock_acoustic",
        "--mode",
        "inprocess",
        "--duration",
        "2",
        "--no-figures",
        "--out",
        "out",
    ]
    done = run(f"from shoal.commands import main\nsys.exit(main({words!r}))", tmp_path)
    assert (done.returncode, "Traceback" in done.stderr) == (0, False), done.stderr
    (folder,) = (tmp_path / "out").iterdir()
    assert (folder / "recording.npz").is_file()


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


def test_what_needs_more_is_refused_in_one_line(tmp_path):
    done = run("from shoal.commands import main\nsys.exit(main(['reproduce']))", tmp_path)
    assert done.returncode == 2
    assert done.stderr == "error: shoal reproduce: this system cannot fork processes; allowed: on Linux\n"
    done = run("from shoal.commands import main\nsys.exit(main(['topic', 'list']))", tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("error: shoal topic: rclpy cannot be imported")
