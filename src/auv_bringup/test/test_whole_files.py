"""Files are written whole or not at all."""

import shutil

import pytest
from full_disk import files_of_at_most

from auv_bringup.whole_files import WriteError, whole_file, write_bytes, write_text


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
