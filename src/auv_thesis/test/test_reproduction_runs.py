"""Claims about the runs of the reproduction: each once, kept, one failing alone, ended by Ctrl-C."""

import io
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest
from full_disk import files_of_at_most

from auv_core.cli.tally import Tally
from auv_core.machine.whole_files import WriteError
from auv_experiment import run_key
from auv_experiment.inprocess import sampled as experiment
from auv_experiment.recording import RecordingError
from auv_thesis.items import RunSpec
from auv_thesis.runs import runner
from auv_thesis.runs.store import Store, resolve_run

FOUR = RunSpec("ch5_four_leaders", ("dt_s=0.1",), 1.0)
ONE = RunSpec("ch5_one_leader", ("dt_s=0.1",), 1.0)
LONGER = RunSpec("ch5_one_leader", ("dt_s=0.1",), 2.0)
WRONG = RunSpec("ch5_one_leader", ("nonsense=1",))
WAIT_S = 30.0


def fly(specs, folder, **options):
    stream = io.StringIO()
    with Tally("runs", stream) as tally:
        flown = runner.fly_all(specs, Store(folder), n_workers=2, tally=tally, **options)
    return flown, stream.getvalue()


@pytest.fixture
def flights(monkeypatch, tmp_path):
    """Count flights, which happen in other processes, by what each leaves in a file."""
    log = tmp_path / "flights.log"
    log.touch()
    fly_truly = experiment.run_in_process

    def counted(scenario, **options):
        with log.open("a") as stream:
            stream.write(f"{scenario.name} {scenario.duration_s:g}\n")
        return fly_truly(scenario, **options)

    monkeypatch.setattr(experiment, "run_in_process", counted)
    return lambda: sorted(log.read_text().splitlines())


def test_a_run_that_is_asked_for_twice_is_flown_once(tmp_path, flights):
    same = RunSpec("ch5_four_leaders", ("dt_s=1.0e-1", "duration_s=1"))
    flown, _ = fly([FOUR, ONE, FOUR, same], tmp_path)
    assert flights() == ["ch5_four_leaders 1", "ch5_one_leader 1"]
    assert flown.resolved[FOUR].key == flown.resolved[same].key != flown.resolved[ONE].key
    assert not flown.failed


def test_the_longest_run_begins_first(tmp_path, monkeypatch):
    order: list[Any] = []
    monkeypatch.setattr(runner, "spread", lambda calls, n, **_: order.extend(c.args[0].spec for c in calls))
    fly([FOUR, LONGER, ONE], tmp_path)
    assert order[0] == LONGER


def test_a_second_call_flies_what_is_new_only(tmp_path, flights):
    first, _ = fly([FOUR], tmp_path)
    second, words = fly([FOUR, ONE], tmp_path)
    assert flights() == ["ch5_four_leaders 1", "ch5_one_leader 1"]
    assert (first.kept, second.kept) == (set(), {first.resolved[FOUR].key})
    assert "runs: 1, and 1 kept" in words
    assert all(time_s > 0.0 for time_s in second.times_s[first.resolved[FOUR].key])


@pytest.mark.parametrize(
    ("costs", "known", "words"),
    [
        ([100.0] * 6, [(50.0, 100.0)], "; they take about 10 min in 2 processes"),
        ([100.0] * 60, [(50.0, 100.0), (25.0, 50.0)], "; they take about 1 h 40 min in 2 processes"),
        ([500.0, 100.0], [(50.0, 100.0)], "; they take about 17 min in 2 processes"),
        ([10.0], [(50.0, 100.0)], ""),
        ([], [], ""),
    ],
)
def test_a_long_call_says_how_long_it_takes_by_what_is_kept(costs, known, words):
    assert runner._duration_words(costs, known, 2) == words


def changed_digit(folder):
    path = folder / "metrics.json"
    path.write_text(re.sub(r"(?<=\.)\d", lambda found: str(9 - int(found[0])), path.read_text(), count=1))


def flipped_recording(folder):
    path = folder / "recording.npz"
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)


def lost_recording(folder):
    (folder / "recording.npz").unlink()


def wrong_types(folder):
    (folder / "run.json").write_text("[1, 2]")


def no_folder(folder):
    shutil.rmtree(folder)
    folder.touch()


@pytest.mark.parametrize("change", [changed_digit, flipped_recording, lost_recording, wrong_types, no_folder])
def test_a_kept_run_that_was_changed_is_flown_again_with_one_warning(tmp_path, flights, change):
    flown, _ = fly([FOUR], tmp_path)
    change(tmp_path / flown.resolved[FOUR].key)
    again, words = fly([FOUR], tmp_path)
    assert flights() == ["ch5_four_leaders 1"] * 2
    assert again.kept == set()
    assert not again.failed
    assert words.count("warning: kept runs were changed or damaged and are flown again") == 1
    assert Store(tmp_path).has(flown.resolved[FOUR])


def test_a_full_disk_ends_the_flying_in_one_line_and_leaves_nothing(tmp_path, monkeypatch):
    put_truly = Store.put

    def put(self, *arguments, **options):
        with files_of_at_most(10):
            put_truly(self, *arguments, **options)

    monkeypatch.setattr(Store, "put", put)
    with pytest.raises(WriteError, match=r"^cannot write .*: File too large$"):
        fly([FOUR, ONE], tmp_path / "runs")
    assert Store(tmp_path / "runs").forget_old() <= 1, "the other may have been killed at work"
    assert list((tmp_path / "runs").iterdir()) == []


def test_fresh_flies_everything_again(tmp_path, flights):
    fly([FOUR], tmp_path)
    fly([FOUR], tmp_path, is_fresh=True)
    assert flights() == ["ch5_four_leaders 1"] * 2


def test_another_source_is_another_run(tmp_path, flights, monkeypatch):
    fly([FOUR], tmp_path)
    monkeypatch.setattr(run_key, "source_version", lambda: "other")
    fly([FOUR], tmp_path)
    assert flights() == ["ch5_four_leaders 1"] * 2
    assert Store(tmp_path).forget_old() == 1
    assert len([path for path in tmp_path.iterdir() if path.is_dir()]) == 1


def test_the_source_of_runs_is_what_they_import():
    files = {"/".join(path.parts[-2:]) for path in run_key._source_files()}
    assert files >= {
        "inprocess/sampled.py",
        "metrics/run.py",
        "inprocess/continuous.py",
        "controllers/pfpd.py",
        "presets/table_2_1.yaml",
        "separation/mathematical.py",
    }
    assert not files & {"report/report.py", "launching/launcher.py", "page/page.py", "cli/progress.py"}
    assert not {file for file in files if file.startswith(("nodes/", "scenarios/"))}


def test_forked_workers_fly_with_the_source_that_their_parent_has_loaded():
    """Otherwise a module that changes meanwhile would be flown under the key of the old one."""
    script = """
import sys
from auv_experiment.inprocess import evaluated_run as flight
from auv_experiment import run_key
flight.load_source()
loaded = {getattr(module, "__file__", None) for module in sys.modules.values()}
print([path.name for path in run_key._imported(run_key._ENTRANCES) if str(path) not in loaded])
"""
    environ = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=WAIT_S, env=environ
    )
    assert done.stdout == "[]\n", done.stderr


def test_plugins_from_elsewhere_belong_to_the_source(tmp_path, monkeypatch):
    monkeypatch.setenv("SHOAL_PLUGINS", str(tmp_path))
    for file in ("separation/gentle.py", "scenarios/mine.yaml", "laws/mine.py"):
        (tmp_path / file).parent.mkdir()
        (tmp_path / file).touch()
    files = run_key._source_files()
    assert {path for path in files if path.is_relative_to(tmp_path)} == {tmp_path / "separation/gentle.py"}


def test_what_is_kept_is_what_was_flown(tmp_path):
    flown, _ = fly([FOUR], tmp_path)
    key = flown.resolved[FOUR].key
    recording = Store(tmp_path).recording(key)
    expected = experiment.run_in_process(resolve_run(FOUR).scenario)
    assert (recording.position_ned_m == expected.position_ned_m).all()
    assert Store(tmp_path).metrics(key)["scenario"] == "ch5_four_leaders"


def test_an_interrupted_store_leaves_no_run_behind_and_one_at_work_is_let_be(tmp_path):
    (tmp_path / "0123.999999999.unfinished").mkdir()
    at_work = tmp_path / f"0123.{os.getpid()}.unfinished"
    at_work.mkdir()
    assert Store(tmp_path).forget_old() == 1
    assert list(tmp_path.iterdir()) == [at_work]
    with pytest.raises(RecordingError, match="not a recording"):
        Store(tmp_path).recording("0123")


def test_a_run_that_cannot_be_resolved_fails_alone(tmp_path):
    flown, words = fly([WRONG, FOUR], tmp_path)
    assert list(flown.failed) == [WRONG]
    assert "unknown key 'nonsense'" in flown.failed[WRONG].line
    assert f"error: {WRONG}: " in words
    assert Store(tmp_path).has(flown.resolved[FOUR])


def test_a_run_that_raises_fails_alone(tmp_path, monkeypatch):
    fly_truly = experiment.run_in_process

    def sink(scenario, **options):
        if scenario.name == "ch5_one_leader":
            raise ArithmeticError("it\nsank")
        return fly_truly(scenario, **options)

    monkeypatch.setattr(experiment, "run_in_process", sink)
    flown, words = fly([ONE, FOUR], tmp_path)
    assert list(flown.failed) == [ONE]
    assert flown.failed[ONE].line == "ArithmeticError: it sank"
    assert "in sink" in flown.failed[ONE].traceback
    assert "error: ch5_one_leader" in words
    assert Store(tmp_path).has(flown.resolved[FOUR])
    assert not Store(tmp_path).has(flown.resolved[ONE])


FLIES_FOR_LONG = """
import sys
from auv_thesis.items import Chapter, Claim, RunSpec, Verdict
from auv_thesis import cli
specs = [RunSpec("flock_acoustic", (f"seed={seed}",)) for seed in range(3)]
claims = tuple(Claim("9", spec.overrides[0], (spec,), lambda runs: Verdict("holds", "")) for spec in specs)
sys.exit(cli.main(["--out", sys.argv[1], "--workers", "2"], [Chapter("ch9", "Long", (), (), claims)]))
"""


@pytest.fixture
def long_command(tmp_path):
    """Start a reproduction that takes long, in a session of its own; give it when its workers fly."""
    started = threading.Event()
    log = tmp_path / "log"
    environ = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    with log.open("wb") as stream:
        process = subprocess.Popen(
            [sys.executable, "-c", FLIES_FOR_LONG, str(tmp_path / "out")],
            stdout=stream,
            stderr=stream,
            env=environ,
            start_new_session=True,
        )
    try:
        wait_until(started, lambda: len(members(process.pid)) == 3)
        yield process, log
    finally:
        if members(process.pid):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait(WAIT_S)


def members(session):
    """Return the processes of a session that still run."""
    found = []
    for path in Path("/proc").iterdir():
        if path.name.isdigit():
            try:
                fields = (path / "stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue
            if int(fields[3]) == session and fields[0] != "Z":
                found.append(int(path.name))
    return found


def wait_until(event, condition):
    for _ in range(int(WAIT_S / 0.05)):
        if condition():
            return
        event.wait(0.05)
    raise AssertionError("it did not happen in time")


@pytest.mark.parametrize("send", [os.kill, os.killpg], ids=["to the command", "to all, as a terminal does"])
def test_ctrl_c_ends_it_in_one_line_and_leaves_no_process(long_command, send):
    process, log = long_command
    send(process.pid, signal.SIGINT)
    assert process.wait(WAIT_S) == 130
    assert members(process.pid) == []
    *_, last = log.read_text().splitlines()
    assert last == "error: interrupted; finished runs are kept for the next call"
    assert "Traceback" not in log.read_text()


def test_a_killed_command_leaves_no_process(long_command):
    process, _ = long_command
    process.kill()
    process.wait(WAIT_S)
    wait_until(threading.Event(), lambda: members(process.pid) == [])
