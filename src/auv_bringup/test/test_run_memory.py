"""Claims about memory: a run that will not fit is refused, and the estimate is near the truth."""

import resource
import subprocess
import sys

import numpy as np
import pytest

from auv_bringup.launching.plan import make_plan
from auv_bringup.tools import run as cli
from auv_core.machine import free_memory
from auv_core.params import ConfigError
from auv_experiment import run_memory
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.recording import Recording
from auv_experiment.recording_shapes import bytes_per_tick
from auv_experiment.scenario.loading import load_scenario

LARGE = ["vehicles.count=64", "random_starts.radius_m=60", "sampling=sampled"]


@pytest.fixture
def free(monkeypatch):
    """Return a function that sets how much memory is free (bytes)."""

    def set_free(size_bytes):
        monkeypatch.setattr(run_memory, "free_bytes", lambda: size_bytes)

    return set_free


def test_a_run_that_does_not_fit_is_refused_in_one_line_and_writes_nothing(free, tmp_path, capsys):
    free(8e9)
    run = ["--mode", "inprocess", "--duration", "1000000", "--out", str(tmp_path / "results")]
    assert cli.main(run) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(
        "error: scenario.duration_s: 1e+06 s of 4 vehicles take about 109 GB of memory, and 8 GB are free; "
        "allowed: at most about 7.1e+04 s here"
    )
    assert not (tmp_path / "results").exists()


def test_what_the_refusal_allows_is_allowed(free):
    free(8e9)
    assert make_plan("flock_acoustic", mode="inprocess", duration_s=7.1e4).scenario.duration_s == 7.1e4


def test_a_day_of_the_main_job_fits_into_ten_gigabytes(free):
    free(10e9)
    make_plan("flock_acoustic", mode="inprocess", duration_s=86_400.0)


def test_64_vehicles_for_650_s_are_refused_where_10_gigabytes_are_free(free):
    free(10e9)
    with pytest.raises(ConfigError, match="64 vehicles take about 22 GB of memory"):
        make_plan("swarm", mode="inprocess", overrides=LARGE, duration_s=650.0)


def test_sweeps_and_programs_are_refused_as_well(free):
    free(1e9)
    with pytest.raises(ConfigError, match="650 s of 64 vehicles take about"):
        run_in_process(load_scenario("swarm", overrides=LARGE, duration_s=650.0))


def test_a_flight_of_nodes_needs_no_memory_for_its_report_but_says_so(free):
    free(3e9)
    plan = make_plan("swarm", mode="lockstep", layout="single", overrides=LARGE, duration_s=650.0)
    line = run_memory.memory_warning(plan.scenario)
    assert line.startswith(
        "metrics and figures of this run take about 20.2 GB of memory, and 3 GB are free: the bag"
    )
    assert "\n" not in line
    assert not run_memory.memory_warning(load_scenario("flock_acoustic"))
    free(1e9)
    with pytest.raises(ConfigError, match=r"scenario\.vehicles: .*; allowed: fewer vehicles$"):
        make_plan("swarm", mode="lockstep", layout="single", overrides=LARGE, duration_s=650.0)


@pytest.mark.parametrize("has_neighbours", [True, False])
def test_the_size_of_a_tick_is_that_of_the_arrays(has_neighbours):
    def size(states):
        recording = Recording.empty(["a", "b", "c"], 0.1 * np.arange(states), has_neighbours=has_neighbours)
        arrays = [value for value in vars(recording).values() if isinstance(value, np.ndarray)]
        return sum(array.nbytes for array in arrays)

    assert bytes_per_tick(3, has_neighbours=has_neighbours) == size(11) - size(10)


def test_limits_of_control_groups_and_of_the_process_count(monkeypatch, tmp_path):
    whole = free_memory.free_bytes()
    group = tmp_path / "a" / "b"
    group.mkdir(parents=True)
    monkeypatch.setattr(free_memory, "_control_groups", lambda: [group, group.parent])
    (group / "memory.max").write_text("max\n")
    assert free_memory.free_bytes() > 0.5 * whole
    (group.parent / "memory.max").write_text("5000000\n")
    (group.parent / "memory.current").write_text("2000000\n")
    assert free_memory.free_bytes() == 3e6
    monkeypatch.setattr(resource, "getrlimit", lambda _: (1000, 1000))
    assert free_memory.free_bytes() == 0.0


_PEAK = """
import resource, sys
from auv_bringup.tools import run as cli
words = ["swarm", "--mode", "inprocess", "--no-bag", "--no-figures", "--out", sys.argv[1], *sys.argv[2:]]
status = cli.main(words)
print(status, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024)
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "duration_s", "overrides"),
    [
        ("flock_acoustic", 650.0, []),
        ("flock_acoustic", 13_000.0, []),
        ("swarm", 1200.0, []),
        ("swarm", 60.0, ["vehicles.count=32", *LARGE[1:]]),
    ],
)
def test_the_estimate_is_near_what_a_run_takes(name, duration_s, overrides, tmp_path):
    sets = [word for override in overrides for word in ("--set", override)]
    code = _PEAK.replace('"swarm"', repr(name))
    run = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path), "--duration", str(duration_s), *sets],
        capture_output=True, text=True, timeout=900, check=True,
    )  # fmt: skip
    status, peak = map(int, run.stdout.split()[-2:])
    assert status == 0
    scenario = load_scenario(name, overrides=overrides, duration_s=duration_s)
    assert run_memory.run_bytes(scenario) == pytest.approx(peak, rel=0.3)
