"""Files are written completely or not at all."""

import shutil

import pytest
from full_disk import files_of_at_most, on_a_tiny_disk

from auv_core.machine.whole_files import (
    WriteError,
    reserve,
    whole_file,
    write_bytes,
    write_reserved,
    write_text,
)


def test_a_file_takes_the_place_of_the_old_one(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    write_text(path, "größer")
    assert path.read_text(encoding="utf-8") == "größer"
    assert list(tmp_path.iterdir()) == [path]


def test_the_unfinished_file_has_the_suffix_of_the_whole_one(tmp_path):
    with whole_file(tmp_path / "figure.png") as unfinished:
        assert unfinished.suffix == ".png"
        unfinished.touch()
    assert (tmp_path / "figure.png").exists()


@pytest.mark.parametrize("old", [None, b"old"])
def test_a_full_disk_is_one_line_and_leaves_what_was_there(tmp_path, old):
    path = tmp_path / "a.bin"
    if old is not None:
        path.write_bytes(old)
    with files_of_at_most(1000), pytest.raises(WriteError) as error:
        write_bytes(path, bytes(2000))
    assert str(error.value) == f"cannot write {path}: File too large"
    assert [file.read_bytes() for file in tmp_path.iterdir()] == ([] if old is None else [old])


def test_a_folder_that_was_moved_away_is_said(tmp_path):
    folder = tmp_path / "results"
    folder.mkdir()
    with pytest.raises(WriteError, match=r"results/a\.txt: its folder is gone"), whole_file(folder / "a.txt"):
        shutil.rmtree(folder)


def test_an_error_of_the_writer_leaves_nothing(tmp_path):
    def write():
        with whole_file(tmp_path / "a.txt") as unfinished:
            unfinished.touch()
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        write()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("text", ["shorter", "a text that is longer than what was reserved: größer"])
def test_a_reserved_file_takes_the_place_of_the_old_one(tmp_path, text):
    path = tmp_path / "a.txt"
    path.write_text("old")
    reserve(path, 20)
    write_reserved(path, text)
    assert path.read_text(encoding="utf-8") == text
    write_reserved(path, "again, with nothing reserved")
    assert path.read_text() == "again, with nothing reserved"
    assert list(tmp_path.iterdir()) == [path]


def test_without_room_nothing_is_reserved(tmp_path):
    with files_of_at_most(1000), pytest.raises(WriteError, match=r"a\.txt: File too large"):
        reserve(tmp_path / "a.txt", 2000)
    assert list(tmp_path.iterdir()) == []


def test_what_was_reserved_is_written_on_a_full_disk(tmp_path):
    said = on_a_tiny_disk(
        tmp_path,
        """
from auv_core.machine.whole_files import WriteError, reserve, write_reserved, write_text

path = disk / "a.txt"
write_text(path, "old")
reserve(path, 100_000)
fill()
try:
    write_text(path, "x" * 90_000)
except WriteError as error:
    print(str(error).rpartition(": ")[2])
print(path.read_text())
write_reserved(path, "x" * 90_000)
print(len(path.read_text()))
""",
    )
    assert said.splitlines() == ["No space left on device", "old", "90000"]
