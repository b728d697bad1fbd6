"""A user who may read this checkout, and write nowhere in it."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
NOBODY = 65534

pytestmark = [
    pytest.mark.ros,
    pytest.mark.slow,
    pytest.mark.skipif(
        os.geteuid() != 0 or not shutil.which("setpriv"), reason="only root can be another user"
    ),
]


@pytest.fixture
def place():
    """A folder of the other user; those of pytest can be entered by root only."""
    folder = Path(tempfile.mkdtemp(prefix="shoal-test-"))
    os.chown(folder, NOBODY, NOBODY)
    yield folder
    shutil.rmtree(folder)


def run(place, command, *arguments):
    """Run a command of this checkout as a user without a home, who may read whatever root may."""
    user = ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups"]
    may_read = ["--inh-caps=+dac_read_search", "--ambient-caps=+dac_read_search"]
    done = subprocess.run(
        [*user, *may_read, str(ROOT / "scripts" / command), *arguments],
        cwd=place,
        env={"PATH": os.environ["PATH"], "HOME": "/nonexistent", "TMPDIR": str(place)},
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )
    assert "Traceback" not in done.stderr
    return done


def test_another_users_checkout_works_without_a_home(place):
    fly = ("flock_acoustic", "--duration", "2", "--no-figures")
    first = run(place, "run", *fly, "--mode", "inprocess")
    again = run(place, "run", *fly, "--mode", "inprocess")
    assert (first.returncode, again.returncode) == (0, 0), first.stderr + again.stderr
    assert "compiling" not in again.stdout  # what was compiled is kept
    assert run(place, "run", *fly, "--layout", "single").returncode == 0
    assert run(place, "topic", "--wait", "0.5", "list").returncode == 0


def test_a_place_that_cannot_be_written_is_one_line_and_status_2(place):
    done = run(place, "run", "flock_acoustic", "--out", str(ROOT / "results-of-nobody"))
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "cannot be written (Permission denied)" in done.stderr
