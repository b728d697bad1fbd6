import json
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from full_disk import on_a_tiny_disk

from auv_bringup.launching.plan import make_plan, start_results
from auv_experiment import results
from auv_experiment.results import (
    ResultsError,
    git_state,
    make_results_dir,
    overrides_hash,
    provenance,
    read_json,
    results_name,
    write_json,
)
from auv_experiment.scenario.loading import load_scenario

needs_git = pytest.mark.skipif(shutil.which("git") is None, reason="git is not needed, and not here")


def test_the_folder_is_named_by_what_was_run():
    assert results_name("flock_acoustic", 3, "lockstep") == "flock_acoustic-3-lockstep"
    assert results_name("a", 0, "inprocess", "0123abcd") == "a-0-inprocess-0123abcd"


def test_no_override_no_hash():
    assert overrides_hash([]) == ""


def test_the_hash_is_eight_hexadecimal_digits_and_always_the_same():
    digest = overrides_hash(["acoustics.outage.params.loss_prob=0.3"])
    assert len(digest) == 8
    assert int(digest, 16) >= 0
    assert digest == overrides_hash(["acoustics.outage.params.loss_prob=0.3"])


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (["a=1", "b=2"], ["b=2", "a=1"]),
        (["a=5", "a=1"], ["a=1"]),
        (["a=20"], ["a=20.0"]),
        (["a=[1, 2]"], ["a=[1.0,2.0]"]),
        (["a={b: 1}"], ["a={b: 1.0}"]),
    ],
)
def test_equal_overrides_have_equal_hashes(first, second):
    assert overrides_hash(first) == overrides_hash(second)


@pytest.mark.parametrize(
    ("first", "second"),
    [(["a=1"], ["a=2"]), (["a=1"], ["b=1"]), (["a=1"], ["a=true"]), (["a=1"], ["a='1'"]), (["a=1"], [])],
)
def test_other_overrides_have_other_hashes(first, second):
    assert overrides_hash(first) != overrides_hash(second)


def test_the_duration_counts_as_an_override():
    assert overrides_hash([], 20.0) == overrides_hash(["duration_s=20"])
    assert overrides_hash(["duration_s=5"], 20.0) == overrides_hash([], 20.0)


def test_an_existing_folder_is_never_used_again(tmp_path):
    names = [make_results_dir(tmp_path / "results", "run").name for _ in range(3)]
    assert names == ["run", "run-2", "run-3"]


def test_runs_that_start_together_get_folders_of_their_own(tmp_path):
    with ThreadPoolExecutor(8) as pool:
        folders = list(pool.map(lambda _: make_results_dir(tmp_path, "run"), range(40)))
    assert len(set(folders)) == 40


def test_a_folder_that_cannot_be_made_is_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ResultsError) as error:
        make_results_dir(tmp_path / "file" / "results", "run")
    assert "--out" in str(error.value)
    assert "\n" not in str(error.value)


def test_provenance_says_what_is_needed_to_repeat_a_run(tmp_path):
    scenario = load_scenario("flock_acoustic", seed=5)
    record = provenance(scenario, mode="lockstep", overrides=["a=1"], duration_s=None)
    write_json(tmp_path / "provenance.json", record)
    read = read_json(tmp_path / "provenance.json")
    assert (read["scenario"], read["seed"], read["mode"]) == ("flock_acoustic", 5, "lockstep")
    assert read["overrides"] == ["a=1"]
    assert "numpy" in read["packages"]
    assert read["python"].startswith("3.")


def test_no_git_state_outside_a_checkout(tmp_path):
    file = tmp_path / "module.py"
    file.write_text("")
    assert git_state(file) is None


@needs_git
def test_git_state_of_a_checkout_but_not_of_a_guest_in_it(tmp_path):
    def git(*arguments):
        identity = ["-c", "user.name=x", "-c", "user.email=x@example.org"]
        subprocess.run(["git", "-C", str(tmp_path), *identity, *arguments], check=True, capture_output=True)

    git("init")
    tracked, guest = tmp_path / "tracked.py", tmp_path / "guest.py"
    tracked.write_text("")
    guest.write_text("")
    git("add", "tracked.py")
    git("commit", "-m", "first")
    state = git_state(tracked)
    assert state is not None
    assert len(state["revision"]) == 40
    assert state["has_local_changes"] is False
    tracked.write_text("changed = True\n")
    state = git_state(tracked)
    assert state is not None
    assert state["has_local_changes"] is True
    assert git_state(guest) is None


def test_without_git_there_is_no_git_state(monkeypatch):
    monkeypatch.setenv("PATH", "")
    assert git_state(Path(results.__file__)) is None


def test_json_is_strict(tmp_path):
    path = tmp_path / "data.json"
    write_json(path, {"a": float("nan"), "b": float("inf"), "c": 1.5})
    assert json.loads(path.read_text(), parse_constant=pytest.fail) == {"a": None, "b": None, "c": 1.5}


@pytest.mark.parametrize("text", ["", "[1]", "{", "\0"])
def test_what_is_no_json_object_reads_as_empty(tmp_path, text):
    path = tmp_path / "data.json"
    path.write_text(text)
    assert read_json(path) == {}
    assert read_json(tmp_path / "missing.json") == {}


def test_a_folder_without_a_recording_is_one_line(tmp_path):
    with pytest.raises(ResultsError) as error:
        results.load_recording(tmp_path, load_scenario("flock_acoustic"))
    assert "\n" not in str(error.value)


def test_on_a_full_disk_the_provenance_of_a_flight_still_says_how_it_ended(tmp_path):
    said = on_a_tiny_disk(
        tmp_path,
        """
import json
from auv_experiment import results
from auv_bringup.launching.plan import make_plan, start_results
from auv_bringup.launching.plan import make_plan, start_results

folder = start_results(make_plan("flock_acoustic", mode="lockstep"), disk)
fill()
results.write_ending(folder, exit_status=3, stopped_because="x" * 1000, strangers=["y" * 100] * 100)
known = json.loads((folder / "provenance.json").read_text())
print(known["seed"], known["exit_status"], len(known["packages"]) > 10)
print(sorted(path.name for path in folder.iterdir()))
""",
    )
    assert said.splitlines() == ["1 3 True", "['logs', 'provenance.json', 'scenario.yaml']"]


@pytest.mark.parametrize(("mode", "is_kept"), [("lockstep", True), ("inprocess", False)])
def test_room_is_kept_for_the_end_of_a_flight_with_nodes_only(tmp_path, mode, is_kept):
    folder = start_results(make_plan("flock_acoustic", mode=mode), tmp_path)
    assert (folder / ".provenance.reserved.json").exists() == is_kept
