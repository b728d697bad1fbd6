"""Claims about kept runs: files that were changed on disk are not used, and do not block a sweep."""

import json
import os

import pytest
from full_disk import files_of_at_most
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_core.machine.kept_json import KeptError, read_kept, write_kept
from auv_core.machine.whole_files import WriteError
from auv_experiment.sweeps.parts import Parts
from auv_experiment.sweeps.worker import Finished

KNOWN = {"metrics": {"a_m": 1.25, "b": True, "c": None}, "word": "x\u00e9", "n": 3}
FINISHED = Finished({"a_m": 1.25, "b": True, "c": None, "d": "word", "n": 3}, wall_s=1.5, cpu_s=1.0)


def test_what_was_written_comes_back(tmp_path):
    write_kept(tmp_path / "a.json", "a", KNOWN)
    assert read_kept(tmp_path / "a.json", "a") == KNOWN


def test_what_is_not_there_is_not_there(tmp_path):
    with pytest.raises(FileNotFoundError):
        read_kept(tmp_path / "a.json", "a")


@pytest.fixture(scope="module")
def text(tmp_path_factory):
    path = tmp_path_factory.mktemp("kept") / "a.json"
    write_kept(path, "a", KNOWN)
    return path.read_bytes()


@settings(deadline=None)
@given(st.data())
def test_no_flipped_bit_changes_what_is_read(text, tmp_path_factory, data):
    place = data.draw(st.integers(0, 8 * len(text) - 1))
    changed = bytearray(text)
    changed[place // 8] ^= 1 << place % 8
    path = tmp_path_factory.getbasetemp() / "flipped.json"
    path.write_bytes(changed)
    try:
        known = read_kept(path, "a")
    except KeptError:
        return
    assert known == KNOWN, "a space that became a tab"


NESTED = b"[" * 100_000


@pytest.mark.parametrize(
    "change",
    [
        lambda text: b"",
        lambda text: text[: len(text) // 2],
        lambda text: text.replace(b"1.25", b"1.26"),
        lambda text: text.replace(b"1.25", b"NaN"),
        lambda text: text.replace(b"1.25", b'"1.25"'),
        lambda text: text.replace(b"checksum", b"chocksum"),
        lambda text: text + text,
        lambda text: b"null",
        lambda text: b"\xff\xfe",
        lambda text: NESTED,
        lambda text: bytes(1 << 25),
    ],
)
def test_what_was_changed_is_refused(text, tmp_path, change):
    path = tmp_path / "a.json"
    path.write_bytes(change(text))
    with pytest.raises(KeptError):
        read_kept(path, "a")


def test_a_file_that_was_renamed_is_refused(tmp_path):
    write_kept(tmp_path / "b.json", "a", KNOWN)
    with pytest.raises(KeptError, match="its checksum is wrong"):
        read_kept(tmp_path / "b.json", "b")


def put_link(path):
    write_kept(path.with_name("other"), "a", KNOWN)
    path.symlink_to("other")


@pytest.mark.timeout(20)
@pytest.mark.parametrize("put", [os.mkfifo, os.mkdir, put_link])
def test_what_is_no_plain_file_is_refused_at_once(tmp_path, put):
    put(tmp_path / "a.json")
    with pytest.raises(KeptError):
        read_kept(tmp_path / "a.json", "a")


def test_a_part_comes_back(tmp_path):
    Parts(tmp_path).put("a", FINISHED)
    assert Parts(tmp_path).get("a") == FINISHED
    assert Parts(tmp_path).get("b") is None


@pytest.mark.parametrize(
    "changes",
    [
        {"metrics": None},
        {"metrics": {"a": []}},
        {"metrics": {"a": 1 << 70}},
        {"error": None},
        {"traceback": 1},
        {"is_lasting": "yes"},
        {"wall_s": "long"},
        {"cpu_s": True},
        {"more": 1},
    ],
)
def test_a_part_of_wrong_types_is_refused_though_its_checksum_holds(tmp_path, changes):
    parts = Parts(tmp_path)
    parts.put("a", FINISHED)
    known = json.loads(parts.path("a").read_text())
    del known["checksum"]
    write_kept(parts.path("a"), "a", {**known, **changes})
    with pytest.raises(KeptError):
        parts.get("a")


def test_a_full_disk_is_told_in_one_line_and_leaves_nothing(tmp_path):
    parts = Parts(tmp_path)
    with files_of_at_most(10), pytest.raises(WriteError, match=r"^cannot write .*a\.json: File too large$"):
        parts.put("a", FINISHED)
    assert parts.get("a") is None
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_what_a_killed_sweep_left_half_written_goes_and_that_of_one_at_work_stays(tmp_path):
    parts = Parts(tmp_path)
    left = [parts.path("a").with_name(f".a.{process}.part.json") for process in (999_999_999, os.getpid())]
    for path in left:
        path.touch()
    parts.forget_old()
    assert [path.exists() for path in left] == [False, True]
