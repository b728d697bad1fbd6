"""Recordings: shapes are checked, files give back what was saved."""

from __future__ import annotations

import io
import zipfile
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from auv_experiment.recording import Recording, RecordingError


def filled_recording(n_ticks: int = 7, n: int = 3, seed: int = 0) -> Recording:
    """Every array full of random numbers, some of them NaN."""
    rng = np.random.default_rng(seed)
    recording = Recording.empty([f"auv_{i + 1}" for i in range(n)], 0.1 * np.arange(n_ticks + 1))
    for field in fields(recording):
        value = getattr(recording, field.name)
        if isinstance(value, np.ndarray) and value.dtype == np.float64 and field.name != "t_s":
            setattr(recording, field.name, rng.normal(size=value.shape))
    recording.centre_ned_m[2, 1] = np.nan
    recording.sent = np.array([[0, 1, 0], [1, 2, 0]])
    recording.received = np.array([[1, 1, 2, 0], [1, 1, 3, 0], [2, 2, 1, 0]])
    recording.delay_s = np.array([0.11, 0.12, 0.13])
    return recording


def test_load_gives_back_every_array_bit_by_bit(tmp_path: Path) -> None:
    saved = filled_recording()
    loaded = Recording.load(saved.save(tmp_path / "recording.npz"))
    assert loaded.vehicle_ids == saved.vehicle_ids
    for field in fields(saved):
        before, after = getattr(saved, field.name), getattr(loaded, field.name)
        if isinstance(before, np.ndarray):
            assert before.dtype == after.dtype
            np.testing.assert_array_equal(before, after)


def test_equal_recordings_give_equal_files_and_leave_nothing_else(tmp_path: Path) -> None:
    first = filled_recording().save(tmp_path / "a.npz").read_bytes()
    second = filled_recording().save(tmp_path / "b.npz").read_bytes()
    assert first == second
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.npz", "b.npz"]


def test_save_keeps_the_name_that_it_is_given(tmp_path: Path) -> None:
    assert filled_recording().save(tmp_path / "run") == tmp_path / "run"
    assert Recording.load(tmp_path / "run").n_ticks == 7


def test_empty_recording_has_nan_everywhere_and_no_packets() -> None:
    recording = Recording.empty(["auv_1", "auv_2"], np.arange(4.0))
    assert (recording.n_vehicles, recording.n_ticks) == (2, 3)
    assert recording.neighbour_covariance.shape == (3, 2, 2, 6, 6)
    assert np.isnan(recording.position_ned_m).all()
    assert np.isnan(recording.lost_at_s).all()
    assert recording.sent.shape == (0, 3)
    assert recording.received.shape == (0, 4)
    assert recording.delay_s.shape == (0,)


def test_empty_recording_owns_its_time() -> None:
    t_s = np.arange(4.0)
    Recording.empty(["auv_1"], t_s).t_s[0] = 5.0
    assert t_s[0] == 0.0


def test_wrong_shape_is_named() -> None:
    recording = filled_recording()
    values = {field.name: getattr(recording, field.name) for field in fields(recording)}
    values["centre_ned_m"] = values["centre_ned_m"][1:]
    with pytest.raises(RecordingError, match="centre_ned_m"):
        Recording(**values)


def test_a_delay_for_every_reception() -> None:
    recording = filled_recording()
    values = {field.name: getattr(recording, field.name) for field in fields(recording)}
    values["delay_s"] = values["delay_s"][:1]
    with pytest.raises(RecordingError, match="delay_s"):
        Recording(**values)


@pytest.mark.parametrize("content", [b"", b"hello", b"PK\x03\x04 broken"])
def test_a_file_that_is_no_recording_is_refused_in_one_line(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "recording.npz"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=r"recording\.npz"):
        Recording.load(path)


def test_every_damage_of_a_file_is_one_line_or_no_damage(tmp_path: Path) -> None:
    whole = filled_recording().save(tmp_path / "whole.npz").read_bytes()
    damaged = [whole[:stop] for stop in range(0, len(whole), 997)]
    for start in range(0, len(whole), 501):
        damaged.append(whole[:start] + bytes(len(whole[start : start + 64])) + whole[start + 64 :])
        damaged.append(whole[:start] + bytes([whole[start] ^ 0x21]) + whole[start + 1 :])
    path = tmp_path / "recording.npz"
    refused = []
    for content in damaged:
        path.write_bytes(content)
        try:
            Recording.load(path)
        except RecordingError as error:
            refused.append(str(error))
    assert len(refused) > len(damaged) // 2
    assert [line for line in refused if "\n" in line or not line.startswith(str(path))] == []


def test_a_file_that_unpacks_to_more_than_the_memory_is_refused_before_it_is_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "recording.npz"
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<f8", "fortran_order": False, "shape": (10**13, 3)}
    )
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("position_ned_m.npy", header.getvalue())
    with pytest.raises(RecordingError, match=r"recording\.npz: it unpacks to 2\.4e\+05 GB"):
        Recording.load(path)


def test_other_arrays_are_no_recording(tmp_path: Path) -> None:
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    np.save(tmp_path / "single.npy", np.zeros(3))
    for name in ("other.npz", "single.npy"):
        with pytest.raises(RecordingError):
            Recording.load(tmp_path / name)
