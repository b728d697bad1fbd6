"""Shared memory of dead processes is removed; that of running processes and other users stays."""

import fcntl
import os
import subprocess
import sys

import pytest

from auv_bringup.launching.shared_memory import clear_shared_memory

HOLD = """
import fcntl, sys
file = open(sys.argv[1])
fcntl.flock(file, fcntl.LOCK_EX if sys.argv[1].endswith("_el") else fcntl.LOCK_SH)
print("held", flush=True)
sys.stdin.read()
"""


MAP = """
import mmap, sys
file = open(sys.argv[1], "rb")
memory = mmap.mmap(file.fileno(), 0, prot=mmap.PROT_READ)
print("mapped", flush=True)
sys.stdin.read()
"""


def make(folder, *names):
    for name in names:
        (folder / name).write_bytes(b"x" * 100)


def left(folder):
    return sorted(path.name for path in folder.iterdir())


SEGMENT = ("fastrtps_00ff00ff00ff00ff", "fastrtps_00ff00ff00ff00ff_el")
PORT = ("fastrtps_port7411", "fastrtps_port7411_el", "sem.fastrtps_port7411_mutex")
SHARED_PORT = (
    "fastrtps_port7400",
    "fastrtps_port7400_el",
    "fastrtps_port7400_sl",
    "sem.fastrtps_port7400_mutex",
)


@pytest.mark.parametrize(
    "names", [SEGMENT, PORT, SHARED_PORT, ("fastdds_0123456789abcdef", "fastdds_0123456789abcdef_el")]
)
def test_what_nobody_holds_goes_whole(tmp_path, names):
    make(tmp_path, *names)
    assert clear_shared_memory(tmp_path) == len(names)
    assert left(tmp_path) == []


@pytest.mark.parametrize(
    ("names", "lock"),
    [(SEGMENT, SEGMENT[1]), (PORT, PORT[1]), (SHARED_PORT, SHARED_PORT[1]), (SHARED_PORT, SHARED_PORT[2])],
)
def test_what_a_process_holds_stays_whole_until_it_is_killed(tmp_path, names, lock):
    make(tmp_path, *names)
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLD, tmp_path / lock], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    try:
        assert holder.stdout is not None
        assert holder.stdout.readline() == b"held\n"
        assert clear_shared_memory(tmp_path) == 0
        assert left(tmp_path) == sorted(names)
    finally:
        holder.kill()
        holder.communicate(timeout=10)
    assert clear_shared_memory(tmp_path) == len(names)


def test_a_port_without_a_lock_stays_while_a_process_has_it_in_its_memory(tmp_path):
    names = ("fastrtps_port7413", "sem.fastrtps_port7413_mutex")
    make(tmp_path, *names)
    sender = subprocess.Popen(
        [sys.executable, "-c", MAP, tmp_path / names[0]], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    try:
        assert sender.stdout is not None
        assert sender.stdout.readline() == b"mapped\n"
        assert clear_shared_memory(tmp_path) == 0
    finally:
        sender.kill()
        sender.communicate(timeout=10)
    assert clear_shared_memory(tmp_path) == 2


def test_other_files_and_traps_stay(tmp_path):
    victim = tmp_path / "victim"
    victim.mkdir()
    make(victim, "file")
    make(tmp_path, "sem.mp-abc", "lttng-ust-wait-6", "fastrtps_of_mine", "fastrtps_00ff_el.txt")
    (tmp_path / "fastrtps_00aa").symlink_to(victim / "file")
    os.mkfifo(tmp_path / "fastrtps_port7777_el")
    before = left(tmp_path)
    assert clear_shared_memory(tmp_path) == 0
    assert left(tmp_path) == before
    assert clear_shared_memory(tmp_path / "nowhere") == 0


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can make files of another user")
def test_what_another_user_has_left_stays(tmp_path):
    make(tmp_path, *SEGMENT)
    for name in SEGMENT:
        os.chown(tmp_path / name, 65534, 65534)
    assert clear_shared_memory(tmp_path) == 0


def test_a_lock_of_this_process_counts(tmp_path):
    make(tmp_path, *SEGMENT)
    with (tmp_path / SEGMENT[1]).open() as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        assert clear_shared_memory(tmp_path) == 0
