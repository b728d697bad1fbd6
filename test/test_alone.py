"""Tests with ROS run two at a time, each process in its own ROS domain, and those marked `alone` alone."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
CONFTEST = f"""
import importlib.util

found = importlib.util.spec_from_file_location("of_the_root", {str(ROOT / "conftest.py")!r})
root = importlib.util.module_from_spec(found)
found.loader.exec_module(root)
root.pytest_configure()
pytest_runtest_protocol = root.pytest_runtest_protocol
"""
TESTS = """
import os
import time
from pathlib import Path

import pytest

def stay(name):
    for word in ("comes", "goes"):
        with Path("said").open("a") as stream:
            stream.write(f"{name} {word} {os.environ['ROS_DOMAIN_ID']}\\n")
        if word == "comes":
            deadline_s = time.monotonic() + 0.3
            while time.monotonic() < deadline_s:
                os.sched_yield()

@pytest.mark.parametrize("number", range(4))
def test_beside(number):
    stay("beside")

@pytest.mark.alone
@pytest.mark.parametrize("number", range(3))
def test_alone(number):
    stay("alone")

@pytest.mark.parametrize("number", range(4))
def test_beside_again(number):
    stay("beside")
"""


@pytest.mark.slow
def test_no_other_test_runs_beside_one_that_is_marked_alone(tmp_path):
    (tmp_path / "conftest.py").write_text(CONFTEST)
    (tmp_path / "test_them.py").write_text(TESTS)
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers =\n    alone: no other test beside it\n")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-n", "2", "-p", "no:cacheprovider", str(tmp_path)],
        cwd=tmp_path,
        env={**os.environ, "ROS_DOMAIN_ID": "40"},
        capture_output=True,
        text=True,
        timeout=120.0,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    said = [line.split() for line in (tmp_path / "said").read_text().splitlines()]
    assert {domain_id for _, _, domain_id in said} == {"40", "60"}
    inside: list[str] = []
    most = 0
    for name, word, _ in said:
        if word == "comes":
            assert name == "beside" or not inside
            assert "alone" not in inside
            inside.append(name)
        else:
            inside.remove(name)
        most = max(most, len(inside))
    assert most == 2
