"""The set-up command names what a machine lacks, leaves nothing half-made, and repeats no work."""

import os
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]


def run_setup(checkout: Path, *arguments: str, timeout_s: float = 60.0, **environment: Any):
    """Run the set-up of `checkout` in a bare environment."""
    return subprocess.run(
        ["/bin/bash", str(checkout / "scripts" / "setup"), *arguments],
        env={"PATH": os.environ["PATH"], "HOME": str(checkout.parent / "home"), **environment},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=timeout_s,
        check=False,
    )


@pytest.fixture
def checkout(tmp_path):
    """Return a new checkout with the files of this one that set-up reads."""
    fresh = tmp_path / "shoal"
    for folder in ("scripts", "requirements"):
        shutil.copytree(ROOT / folder, fresh / folder, ignore=shutil.ignore_patterns("__pycache__"))
    return fresh


@pytest.fixture
def commands(tmp_path):
    """Return a folder that has every command of the system, to take some out of and put others into."""
    folder = tmp_path / "commands"
    folder.mkdir()
    for source in ("/usr/bin", "/bin"):
        for command in Path(source).iterdir():
            link = folder / command.name
            if not link.is_symlink():
                link.symlink_to(command)
    return folder


def put_command(folder: Path, name: str, script: str) -> Path:
    command = folder / name
    command.unlink(missing_ok=True)
    command.write_text(f"#!/bin/sh\n{script}\n")
    command.chmod(0o755)
    return command


def assert_refused(result, checkout: Path, *words: str):
    assert result.returncode == 1
    for word in words:
        assert word in result.stderr
    assert result.stdout == ""
    assert not list(checkout.glob(".venv*/*")), "something half-made was left"
    assert not (checkout / "build").exists()


def test_a_missing_compiler_and_make_are_named_together_with_one_cure(checkout, commands):
    (commands / "g++").unlink(missing_ok=True)
    (commands / "make").unlink(missing_ok=True)
    result = run_setup(checkout, PATH=str(commands))
    # What else this machine may lack (headers, venv) comes before them in the same command.
    assert_refused(result, checkout, "a C++ compiler (g++)", "- make", "apt-get install -y", "g++ make\n")


def test_a_python_that_is_too_old_is_refused(checkout, tmp_path):
    old = put_command(tmp_path, "python3.9", 'case "$*" in *split*) echo 3.9.2 ;; *) exit 1 ;; esac')
    result = run_setup(checkout, SHOAL_PYTHON=str(old))
    assert_refused(result, checkout, "Python 3.11 or newer (found: 3.9.2", "apt-get install -y python3")


def test_missing_headers_and_venv_module_are_named_with_their_packages(checkout, tmp_path):
    # Good enough to be asked, with no venv module and no headers.
    bare = put_command(
        tmp_path, "python3", 'case "$*" in *-S*) exec /usr/bin/env python3 "$@" ;; *) exit 1 ;; esac'
    )
    put_command(
        tmp_path, "real", f'case "$*" in *_base_executable*) echo {bare} ;; *) exec {bare} "$@" ;; esac'
    )
    result = run_setup(checkout, SHOAL_PYTHON=str(tmp_path / "real"))
    assert_refused(result, checkout, "the venv module", "Python.h", "-venv", "-dev")


def test_another_processor_is_refused(checkout, commands):
    put_command(commands, "uname", '[ "$1" = -s ] && echo Linux || echo aarch64')
    assert_refused(
        run_setup(checkout, PATH=str(commands)), checkout, "x86_64 only", "aarch64", "Install ROS 2 Jazzy"
    )


def test_another_ros_distribution_is_refused(checkout, tmp_path):
    (tmp_path / "humble/lib/python3.10/site-packages/rclpy").mkdir(parents=True)
    result = run_setup(checkout, AMENT_PREFIX_PATH=str(tmp_path / "humble"), ROS_DISTRO="humble")
    assert_refused(result, checkout, "ROS 2 'humble' is sourced", "needs Jazzy")


def test_a_sourced_jazzy_asks_for_the_python_that_it_was_made_for(checkout, tmp_path):
    (tmp_path / "jazzy/lib/python3.99/site-packages/rclpy").mkdir(parents=True)
    result = run_setup(checkout, AMENT_PREFIX_PATH=str(tmp_path / "jazzy"), ROS_DISTRO="jazzy")
    assert_refused(result, checkout, "Python 3.99")


def test_a_folder_that_ros_cannot_build_in_is_refused(checkout, tmp_path):
    spaced = checkout.rename(tmp_path / "with space")
    assert_refused(run_setup(spaced), spaced, "with a space", "Move the checkout")


def test_check_changes_nothing(checkout):
    result = run_setup(checkout, "--check")
    assert_refused(result, checkout, "missing or out of date", "./scripts/setup")
    assert not (checkout / ".venv.lock").exists()


@pytest.mark.ros  # only where the workspace is built
@pytest.mark.alone
def test_set_up_again_does_nothing_and_is_quick():
    environment: dict[str, Any] = {
        key: os.environ[key]
        for key in ("AMENT_PREFIX_PATH", "ROS_DISTRO", "SHOAL_PYTHON")
        if key in os.environ
    }
    start_s = time.monotonic()
    result = run_setup(ROOT, "--check", **environment)
    spent_s = time.monotonic() - start_s
    assert (result.returncode, result.stderr) == (0, ""), "the workspace is out of date: run ./scripts/setup"
    assert spent_s < 5.0


def run_venv_on_path(checkout: Path, command: str, ros: Path | None = None) -> int:
    """Run a function of scripts/venv_on_path.bash in `checkout`, with the ROS in `ros` sourced."""
    script = f'set -eu; source "$1"/places.bash; source "$1"/venv_on_path.bash; {command}'
    environment = {"PATH": os.environ["PATH"], **({"AMENT_PREFIX_PATH": str(ros)} if ros else {})}
    return subprocess.run(
        ["/bin/bash", "-c", script, "bash", str(checkout / "scripts")],
        env=environment,
        timeout=60.0,
        check=False,
    ).returncode


@pytest.mark.ros  # reads what colcon made
@pytest.mark.parametrize("name", ["setup.bash", "local_setup.bash"])
def test_beside_a_sourced_jazzy_the_install_folder_brings_the_venv(checkout, tmp_path, name):
    ros = tmp_path / "jazzy"
    (ros / "lib/python3.99/site-packages/rclpy").mkdir(parents=True)
    install = checkout / "install"
    install.mkdir()
    for made in ("setup.bash", "local_setup.bash", "_local_setup_util_sh.py"):
        shutil.copy(ROOT / "install" / made, install)
    assert run_venv_on_path(checkout, "has_venv_on_path", ros) == 1
    for _ in range(2):
        assert run_venv_on_path(checkout, "put_venv_on_path; has_venv_on_path", ros) == 0

    # Sourced twice, after another workspace: it is there once, and behind what was there.
    sourced = subprocess.run(
        ["/bin/bash", "-c", 'source "$1"; source "$1"; echo "$PYTHONPATH"', "bash", str(install / name)],
        env={"PATH": os.environ["PATH"], "PYTHONPATH": "/other"},
        capture_output=True,
        text=True,
        timeout=60.0,
        check=True,
    )
    entries = sourced.stdout.strip().split(":")
    site_packages = str(checkout / ".venv-jazzy/lib/python3.99/site-packages")
    assert entries.count(site_packages) == 1
    assert entries.index("/other") < entries.index(site_packages)
    assert sourced.stderr == ""


def test_ros_from_pypi_needs_no_venv_on_the_path(checkout):
    assert run_venv_on_path(checkout, "has_venv_on_path") == 0


@pytest.mark.slow
def test_without_a_network_set_up_says_so_and_the_next_one_starts_again(checkout):
    nowhere = "http://127.0.0.1:9"
    for _ in range(2):
        result = run_setup(
            checkout, HTTPS_PROXY=nowhere, HTTP_PROXY=nowhere, https_proxy=nowhere, http_proxy=nowhere
        )
        assert result.returncode == 1
        assert "making .venv" in result.stderr
        assert "the Python package index cannot be reached" in result.stderr
        assert "HTTPS_PROXY" in result.stderr
        assert not (checkout / ".venv" / ".installed").exists()
