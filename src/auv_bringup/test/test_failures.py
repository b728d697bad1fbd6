"""How commands end after an error."""

import errno
import io
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from full_disk import files_of_at_most

from auv_bringup.tools import replay, topic
from auv_bringup.tools import run as cli
from auv_core.cli.failures import BAD_INPUT, DONE, FAILED, NOT_WRITTEN, answered, internal_error
from auv_core.cli.progress import Progress
from auv_core.machine.whole_files import write_text
from auv_experiment.sweeps import cli as sweeps
from auv_thesis import cli as reproduction

SOURCES = ":".join(str(path) for path in Path(__file__).parents[2].iterdir() if path.name.startswith("auv_"))


def raises(error):
    def command():
        raise error

    return command


def test_errors_have_a_status_and_one_line(capsys, keep_signal_handlers):
    full = OSError(errno.ENOSPC, "No space left on device", "results/log")
    for error, status, line in (
        (ValueError("no"), BAD_INPUT, "error: no\n"),
        (full, NOT_WRITTEN, "error: cannot write results/log: No space left on device\n"),
    ):
        assert answered(raises(error), (ValueError,)) == status
        assert capsys.readouterr().err == line


def test_a_full_disk_is_one_line_and_status_3(tmp_path, capsys, keep_signal_handlers):
    def write():
        write_text(tmp_path / "a.txt", "x" * 2000)
        return DONE

    with files_of_at_most(100):
        status = answered(write, ())
    assert status == NOT_WRITTEN
    assert capsys.readouterr().err == f"error: cannot write {tmp_path / 'a.txt'}: File too large\n"


@pytest.mark.parametrize("folder", ["logs", "gone"])
def test_an_internal_error_survives_a_full_disk(tmp_path, monkeypatch, folder):
    (tmp_path / "logs").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    try:
        raise ZeroDivisionError("boo")
    except ZeroDivisionError as error:
        with files_of_at_most(10):
            line = internal_error(error, tmp_path / folder)
        elsewhere = internal_error(error, tmp_path / "gone")
    assert line.startswith("ZeroDivisionError: boo, at ")
    assert "test_failures.py:" in line
    assert "the traceback cannot be written (File too large)" in line
    assert "the traceback is in " in elsewhere


PRINTS_AND_WRITES = """
import sys
from pathlib import Path
from auv_core.cli.failures import answered
def command():
    sys.stdin.readline()
    for _ in range(3):
        print("x" * 100_000, flush=True)
        print("y" * 100_000, file=sys.stderr, flush=True)
    Path(sys.argv[1]).write_text("reached")
    return 0
sys.exit(answered(command, ()))
"""


@pytest.mark.parametrize("is_full", [False, True])
def test_a_command_outlives_a_closed_terminal_and_a_full_log(tmp_path, is_full):
    with Path("/dev/full").open("w") as full:
        process = subprocess.Popen(
            [sys.executable, "-c", PRINTS_AND_WRITES, str(tmp_path / "status")],
            stdin=subprocess.PIPE,
            stdout=full if is_full else subprocess.PIPE,
            stderr=subprocess.PIPE,
            env={"PYTHONPATH": SOURCES},
        )
    for stream in (process.stdout, process.stderr):
        if stream is not None:
            stream.close()
    assert process.stdin is not None
    process.stdin.write(b"\n")
    process.stdin.close()
    assert process.wait(20) == (NOT_WRITTEN if is_full else DONE)
    assert (tmp_path / "status").read_text() == "reached"


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
@pytest.mark.parametrize("main", [cli.main, sweeps.main, reproduction.main, replay.main, topic.main])
def test_help_is_readable_in_every_terminal(monkeypatch, keep_signal_handlers, main, encoding):
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, encoding=encoding))
    with pytest.raises(SystemExit) as end:
        main(["--help"])
    sys.stdout.flush()
    assert end.value.code == 0
    assert b"usage" in raw.getvalue()


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_messages_of_any_alphabet_reach_every_terminal(monkeypatch, keep_signal_handlers, encoding):
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stderr", io.TextIOWrapper(raw, encoding=encoding))

    def command():
        with Progress(10.0) as progress:
            progress.message("ż → 1")
        raise ZeroDivisionError("Ω")

    assert answered(command, (), explained=str) == FAILED
    assert raw.getvalue() == b"\\u017c \\u2192 1\nerror: \\u03a9\n"
