"""The run command without ROS: refusals, files and output."""

import importlib
import json
import os
import select
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from full_disk import files_of_at_most

from auv_bringup.launching import launcher
from auv_bringup.launching.plan import make_plan
from auv_bringup.tools import run as cli
from auv_experiment import results
from auv_experiment.figures import by_law as law_figures
from auv_experiment.inprocess import sampled as experiment
from auv_experiment.scenario.file import SCENARIOS_DIR
from auv_experiment.scenario.loading import list_scenarios, load_scenario

SOURCES = [str(path) for path in Path(__file__).parents[2].iterdir() if path.name.startswith("auv_")]


def run(tmp_path, *arguments):
    return cli.main([*arguments, "--out", str(tmp_path / "results")])


def folders(tmp_path):
    parent = tmp_path / "results"
    return sorted(path.name for path in parent.iterdir()) if parent.exists() else []


@pytest.fixture(autouse=True)
def _keep_signal_handlers(keep_signal_handlers):
    """Every test here calls the command."""


def test_list_has_one_line_per_scenario(capsys):
    assert cli.main(["--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [name for name, _ in list_scenarios()]
    assert all(title in line for line, (_, title) in zip(lines, list_scenarios(), strict=True))


def test_help_names_every_option_and_exit_status(capsys):
    with pytest.raises(SystemExit) as stop:
        cli.main(["--help"])
    assert stop.value.code == 0
    text = capsys.readouterr().out
    for word in (
        "--mode",
        "--seed",
        "--set",
        "--duration",
        "--out",
        "--no-bag",
        "--list",
        "--discovery",
        "130",
        "-2",
    ):
        assert word in text
    assert max(len(line) for line in text.split("three ways")[1].splitlines()) <= 90


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["nonesuch"], "nonesuch"),
        (["missing/file.yaml"], "missing/file.yaml"),
        (["--set", "vehicles"], "vehicles"),
        (["--set", "acoustics.outage.params.loss_prob=2"], "loss_prob"),
        (["--set", "nonesuch=2"], "nonesuch"),
        (["--set", "leaders=[auv_9]"], "auv_9"),
        (["--set", "dt_s=0.03"], "dt_s"),
        (["--seed", "-1"], "seed"),
        (["--duration", "0"], "duration"),
        (["--duration", "nan"], "duration"),
        (["--duration", "0.05"], "duration"),
        (["--layout", "single", "--mode", "inprocess"], "inprocess"),
        (
            ["--layout", "single", "--mode", "lockstep", "--set", "on_vehicle_loss=continue"],
            "on_vehicle_loss",
        ),
    ],
)
def test_bad_input_is_one_line_status_2_and_no_folder(tmp_path, capsys, arguments, word):
    assert run(tmp_path, *arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("error: ")
    assert captured.err.count("\n") == 1
    assert word in captured.err
    assert folders(tmp_path) == []


@pytest.mark.parametrize(
    "arguments",
    [
        ["--mode", "fast"],
        ["--layout", "pair"],
        ["--seed", "x"],
        ["--duration", "x"],
        ["--nonesuch"],
        ["a", "b"],
        ["--list", "--report", "x"],
    ],
)
def test_a_bad_option_is_one_line_and_status_2(tmp_path, capsys, arguments):
    with pytest.raises(SystemExit) as stop:
        run(tmp_path, *arguments)
    assert stop.value.code == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("error: ")
    assert captured.err.count("\n") == 1
    assert folders(tmp_path) == []


def test_a_bad_ros_domain_is_bad_input(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "150")
    monkeypatch.setattr(cli, "_check_ros", lambda _: None)
    assert run(tmp_path, "--mode", "lockstep") == 2
    assert "150" in capsys.readouterr().err
    assert folders(tmp_path) == []


def test_nodes_without_ros_are_bad_input(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert run(tmp_path, "--mode", "lockstep") == 2
    assert "rclpy" in capsys.readouterr().err
    assert folders(tmp_path) == []


def test_a_run_in_one_process_leaves_everything_and_says_it_last(tmp_path, capsys):
    assert run(tmp_path, "--mode", "inprocess", "--duration", "2", "--seed", "3") == 0
    (name,) = folders(tmp_path)
    assert name.startswith("flock_acoustic-3-inprocess-")
    folder = tmp_path / "results" / name
    for file in ("scenario.yaml", "provenance.json", "metrics.json", "recording.npz", "report.html"):
        assert (folder / file).is_file(), file
    assert list((folder / "figures").glob("*.png"))
    metrics = json.loads((folder / "metrics.json").read_text())
    assert (metrics["seed"], metrics["mode"], metrics["scenario"]) == (3, "inprocess", "flock_acoustic")
    lines = capsys.readouterr().out.splitlines()
    assert lines[-1] == f"report: {folder / 'report.html'}"
    assert any("two hulls touched" in line for line in lines)


RUN_WITHOUT_FIGURES = """
import sys
from auv_bringup.tools.run import main

words = ["ch2_pfpd", "--mode", "inprocess", "--duration", "1", "--no-figures", "--out", sys.argv[1]]
assert main(words) == 0
print([name for name in sys.modules if name.partition(".")[0] == "matplotlib"])
"""


def test_a_run_without_figures_does_not_load_what_draws_them(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", RUN_WITHOUT_FIGURES, str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=120.0,
        check=True,
    )
    assert done.stdout.splitlines()[-1] == "[]"


def test_the_written_scenario_gives_the_same_run(tmp_path):
    run(
        tmp_path,
        "--mode",
        "inprocess",
        "--duration",
        "1",
        "--set",
        "acoustics.outage.params.loss_prob=0.5",
        "--no-figures",
    )
    (name,) = folders(tmp_path)
    written = load_scenario(str(tmp_path / "results" / name / "scenario.yaml"))
    assert written == load_scenario(
        "flock_acoustic", overrides=["acoustics.outage.params.loss_prob=0.5"], duration_s=1.0
    )


def test_nothing_is_overwritten_and_the_user_is_told(tmp_path, capsys):
    for _ in range(2):
        run(tmp_path, "--mode", "inprocess", "--duration", "1", "--no-figures")
    first, second = folders(tmp_path)
    assert second == f"{first}-2"
    assert f"{first} exists and is not changed" in capsys.readouterr().out


def test_without_a_recording_there_are_metrics_all_the_same(tmp_path):
    run(tmp_path, "--mode", "inprocess", "--duration", "1", "--no-bag", "--no-figures")
    (name,) = folders(tmp_path)
    files = {path.name for path in (tmp_path / "results" / name).iterdir()}
    assert "recording.npz" not in files
    assert "metrics.json" in files


def test_a_report_is_made_again_from_the_recording(tmp_path, capsys):
    run(tmp_path, "--mode", "inprocess", "--duration", "1", "--no-figures")
    (name,) = folders(tmp_path)
    folder = tmp_path / "results" / name
    before = (folder / "metrics.json").read_text()
    (folder / "metrics.json").unlink()
    (folder / "report.html").unlink()
    assert cli.main(["--report", str(folder), "--no-figures"]) == 0
    after = json.loads((folder / "metrics.json").read_text())
    expected = json.loads(before)
    expected["real_time_factor"] = after["real_time_factor"]
    assert after == expected
    assert (folder / "report.html").is_file()


def test_a_report_of_a_damaged_recording_is_bad_input(tmp_path, capsys):
    assert run(tmp_path, "--mode", "inprocess", "--duration", "1", "--no-figures") == 0
    (name,) = folders(tmp_path)
    path = tmp_path / "results" / name / "recording.npz"
    content = bytearray(path.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 4096] = bytes(4096)
    path.write_bytes(content)
    capsys.readouterr()
    assert cli.main(["--report", str(path.parent)]) == 2
    errors = capsys.readouterr().err
    assert errors.count("\n") == 1
    assert f"{path} is damaged or not a recording" in errors


def test_a_report_of_nothing_is_bad_input(tmp_path, capsys):
    assert cli.main(["--report", str(tmp_path)]) == 2
    assert capsys.readouterr().err.startswith("error: --report")


def test_touching_hulls_give_status_4_and_a_report(tmp_path):
    raw = yaml.safe_load((SCENARIOS_DIR / "ch5_one_leader.yaml").read_text())
    raw["name"] = "meeting"
    raw["duration_s"] = 10.0
    raw["sampling"] = "sampled"
    raw["agent"]["separation"] = {"kind": raw["agent"]["separation"]["kind"]}
    raw["vehicles"] = raw["vehicles"][:2]
    raw["leaders"] = [vehicle["id"] for vehicle in raw["vehicles"]]
    raw["vehicles"][0]["position_ned_m"] = [0.0, 10.0, 10.0]
    raw["vehicles"][1]["position_ned_m"] = [0.7, 10.0, 10.0]
    path = tmp_path / "meeting.yaml"
    path.write_text(yaml.safe_dump(raw))
    recording = experiment.run_in_process(load_scenario(str(path)))
    recording.position_ned_m[5, 1] = recording.position_ned_m[5, 0]

    def collide(scenario, *, on_progress):
        return recording

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(experiment, "run_in_process", collide)
        assert run(tmp_path, str(path), "--mode", "inprocess", "--no-figures") == 4
    (name,) = folders(tmp_path)
    assert json.loads((tmp_path / "results" / name / "metrics.json").read_text())["collision"] is True


def test_the_provenance_of_a_flight_keeps_the_status_that_its_recording_gives(tmp_path, monkeypatch):
    flown = launcher.Flight(0, "", (), 650.0, 50.0, 1.0)
    touched = {"duration_s": 650.0, "collision": True}
    monkeypatch.setattr(cli, "_check_ros", lambda _: None)
    monkeypatch.setattr(launcher, "fly", lambda *_, **__: flown)
    monkeypatch.setattr(results, "load_recording", lambda *_: None)
    monkeypatch.setattr(cli, "_show_results", lambda *_: touched)
    assert run(tmp_path, "--mode", "lockstep") == 4
    (name,) = folders(tmp_path)
    known = json.loads((tmp_path / "results" / name / "provenance.json").read_text())
    assert (known["exit_status"], known["stopped_because"], known["simulated_s"]) == (4, None, 650.0)


@pytest.mark.parametrize("kind", ["metrics", "figures"])
def test_own_files_that_cannot_be_used_are_one_line_before_the_flight(tmp_path, capsys, monkeypatch, kind):
    package = importlib.import_module(f"auv_experiment.{kind}")
    monkeypatch.setattr(package, "__path__", list(package.__path__))
    monkeypatch.setenv("SHOAL_PLUGINS", str(tmp_path))
    (tmp_path / kind).mkdir()
    (tmp_path / kind / "own_broken.py").write_text("import no_such_module_at_all\n")
    assert run(tmp_path, "--mode", "inprocess") == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"error: {kind}/own_broken.py: cannot be imported (ModuleNotFoundError: ")
    assert folders(tmp_path) == []


def test_an_internal_error_leaves_its_traceback_in_the_logs(tmp_path, capsys, monkeypatch):
    def broken(*_):
        raise ZeroDivisionError("first line\nsecond line")

    monkeypatch.setattr(law_figures, "run_drawers", broken)
    assert run(tmp_path, "--mode", "inprocess", "--duration", "1") == 1
    (name,) = folders(tmp_path)
    last = capsys.readouterr().err.splitlines()[-1]
    path = tmp_path / "results" / name / "logs" / "traceback.txt"
    assert last.startswith("error: ZeroDivisionError: first line second line")
    assert str(path) in last
    assert "in broken" in path.read_text()


@pytest.mark.parametrize(("size_bytes", "left"), [(30_000, {"scenario.yaml", "provenance.json"}), (1, None)])
def test_a_full_disk_is_status_3_one_line_and_nothing_half_written(tmp_path, capsys, size_bytes, left):
    with files_of_at_most(size_bytes):
        assert run(tmp_path, "--mode", "inprocess", "--duration", "20") == 3
    last = capsys.readouterr().err.splitlines()[-1]
    assert last.startswith(f"error: cannot write {tmp_path}")
    assert last.endswith("File too large")
    if left is None:
        assert folders(tmp_path) == []  # it did not start
    else:
        (name,) = folders(tmp_path)
        files = {path.name for path in (tmp_path / "results" / name).rglob("*") if path.is_file()}
        assert files == left


@pytest.mark.parametrize("change", ["moved", "removed"])
def test_results_that_are_moved_or_removed_in_flight_are_one_line(tmp_path, capsys, monkeypatch, change):
    fly = experiment.run_in_process

    def disturbed(*arguments, **options):
        recording = fly(*arguments, **options)
        folder = tmp_path / "results"
        shutil.rmtree(folder) if change == "removed" else folder.rename(tmp_path / "elsewhere")
        return recording

    monkeypatch.setattr(experiment, "run_in_process", disturbed)
    assert run(tmp_path, "--mode", "inprocess", "--duration", "1") == 3
    errors = capsys.readouterr().err.splitlines()
    assert "recording.npz: its folder is gone: it was moved or removed" in errors[-1]


def test_an_interrupted_run_in_one_process_leaves_no_folder(tmp_path):
    process = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "auv_bringup.tools.run",
            "--mode",
            "inprocess",
            "--out",
            str(tmp_path / "results"),
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(SOURCES)},
    )
    assert process.stdout is not None
    for line in process.stdout:
        if line.startswith("results go to"):
            break
    assert folders(tmp_path)
    process.send_signal(signal.SIGTERM)
    assert select.select([os.pidfd_open(process.pid)], [], [], 60.0)[0]
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "interrupted" in errors
    assert "Traceback" not in errors
    assert folders(tmp_path) == []


def test_a_continuous_scenario_is_flown_in_one_process():
    plan = make_plan("ch5_one_leader")
    assert (plan.mode, plan.scenario.sampling, plan.is_switched) == ("inprocess", "continuous", False)


@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
def test_nodes_fly_a_continuous_scenario_sampled(mode):
    plan = make_plan("ch5_one_leader", mode=mode)
    assert (plan.mode, plan.scenario.sampling, plan.is_switched) == (mode, "sampled", True)
    assert plan.name == f"ch5_one_leader-{plan.scenario.seed}-{mode}"


def test_a_sampled_scenario_is_flown_in_lock_step():
    plan = make_plan("flock_acoustic")
    assert (plan.mode, plan.is_switched) == ("lockstep", False)


def test_overrides_change_the_name_of_the_results():
    names = {
        make_plan("flock_acoustic", **options).name
        for options in (
            {},
            {"duration_s": 20.0},
            {"overrides": ["period_s=0.2"]},
            {"seed": 2},
            {"mode": "inprocess"},
        )
    }
    assert len(names) == 5
