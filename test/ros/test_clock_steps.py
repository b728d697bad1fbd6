"""
Claim: a step of the system clock, as a time service makes it, is one warning and changes no flight.

It is so in real time even where the waits of the middleware follow the clock that was stepped no more.
"""

import os
import struct
import subprocess
import sys
import threading
import time

import pytest
import yaml

pytest.importorskip("rclpy")

from ros_desk import clock_library

from auv_bag.bag import Bag
from auv_experiment.recording_from_bag import read_recording
from auv_experiment.scenario.file import SCENARIOS_DIR
from auv_experiment.scenario.loading import load_scenario

pytestmark = pytest.mark.ros

PATIENCE_S = 120.0
# A step back and a step ahead, one in each mode, fly in every test run.
QUICK = {("realtime", -20), ("lockstep", 3600)}
CASES = [
    pytest.param(mode, step_s, marks=() if (mode, step_s) in QUICK else pytest.mark.slow)
    for mode in ("realtime", "lockstep")
    for step_s in (-3600, -20, 20, 3600)
]
LAYOUTS_WITHOUT_WAITS = [
    pytest.param(layout, step_s, marks=() if (layout, step_s) == ("single", -3600) else pytest.mark.slow)
    for layout in ("single", "vehicle", "node")
    for step_s in (-3600, -20, 20, 3600)
]
DURATION_S = {"realtime": 3.0, "lockstep": 120.0}


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """Return the library that shifts the system clock of a process that preloads it."""
    return clock_library(tmp_path_factory.mktemp("clock"))


@pytest.fixture(scope="module")
def library_without_waits(tmp_path_factory):
    """Return the library that does not shift waits: one step makes them too short or endless."""
    return clock_library(tmp_path_factory.mktemp("clock"), "-DWITHOUT_WAITS")


@pytest.fixture
def scenario_file(tmp_path):
    """Two kinematic vehicles."""
    raw = yaml.safe_load((SCENARIOS_DIR / "ch5_four_leaders.yaml").read_text())
    raw.update(name="pair", sampling="sampled", vehicles=raw["vehicles"][:2])
    raw["leaders"] = [vehicle["id"] for vehicle in raw["vehicles"]]
    path = tmp_path / "pair.yaml"
    path.write_text(yaml.safe_dump(raw))
    return path


def fly_through_a_step(scenario_file, library, mode, step_s, layout="single"):
    """Fly, step the clock once all nodes are up; return status, console and results folder."""
    shift, console, out = (scenario_file.parent / name for name in ("shift", "console", "results"))
    shift.write_bytes(struct.pack("=q", 0))
    command = [
        sys.executable,
        "-m",
        "auv_bringup.tools.run",
        str(scenario_file),
        "--mode",
        mode,
        "--no-figures",
    ]
    command += ["--layout", layout, "--duration", str(DURATION_S[mode]), "--out", str(out)]
    environ = {**os.environ, "LD_PRELOAD": str(library), "CLOCK_SHIFT_FILE": str(shift)}
    with console.open("wb") as stream:
        run = subprocess.Popen(command, env=environ, stdout=stream, stderr=stream)
    try:
        pause, deadline_s = threading.Event(), time.monotonic() + PATIENCE_S
        while "all nodes are up" not in console.read_text():
            assert time.monotonic() < deadline_s, console.read_text()
            assert run.poll() is None, console.read_text()
            pause.wait(0.02)
        with shift.open("r+b") as stream:
            stream.write(struct.pack("=q", step_s))
        status = run.wait(PATIENCE_S)
    finally:
        run.kill()
        run.wait()
    (folder,) = out.iterdir()
    return status, console.read_text(), folder


@pytest.mark.alone
@pytest.mark.parametrize(("mode", "step_s"), CASES)
def test_a_flight_goes_on_over_a_step_of_the_system_clock(mode, step_s, scenario_file, library):
    check(fly_through_a_step(scenario_file, library, mode, step_s), mode, step_s)


@pytest.mark.alone
@pytest.mark.parametrize(("layout", "step_s"), LAYOUTS_WITHOUT_WAITS)
def test_a_flight_in_real_time_needs_no_timed_wait_of_the_middleware(
    layout, step_s, scenario_file, library_without_waits
):
    flown = fly_through_a_step(scenario_file, library_without_waits, "realtime", step_s, layout)
    check(flown, "realtime", step_s)


def check(flown, mode, step_s):
    """Check that the flight came to its end, and that the step was one warning."""
    status, console, folder = flown
    assert status == 0, console
    assert console.count("the system clock was stepped by") == 1
    assert f"stepped by {step_s:+.1f} s; the run goes on by the steady clock" in console
    bag = Bag(folder)
    assert bag.complete
    first_ns, last_ns = bag.span_ns()
    assert 1e-9 * (last_ns - first_ns) == pytest.approx(DURATION_S[mode], abs=0.5)
    recorded = read_recording(folder, load_scenario(str(folder / "scenario.yaml")))
    assert recorded.t_s[-1] == pytest.approx(DURATION_S[mode], abs=0.5)
