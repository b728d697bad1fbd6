"""Checks of the user's ROS 2 environment."""

import os
import stat
import subprocess
import tempfile

import pytest

from auv_bringup.launching.node_start import node_environment
from auv_bringup.launching.ros_environment import check_ros_environment, log_folder, private_folder
from auv_core.params import ConfigError


@pytest.mark.ros
@pytest.mark.parametrize(
    ("variable", "text"),
    [
        ("RMW_IMPLEMENTATION", "rmw_of_nobody_cpp"),
        ("RMW_IMPLEMENTATION", "rmw_implementation"),
        ("ROS_SECURITY_ENABLE", "True"),
        ("ROS_LOG_DIR", "/proc/nolog"),
        ("ROS_HOME", "/dev/null"),
    ],
)
def test_what_cannot_be_had_is_one_line_that_names_variable_and_value(variable, text):
    with pytest.raises(ConfigError, match=f"^{variable}: .*; allowed: ") as error:
        check_ros_environment({variable: text})
    assert "\n" not in str(error.value)
    assert text.lower() in str(error.value).lower()


@pytest.mark.ros
def test_what_is_installed_is_used(tmp_path):
    usual = {"ROS_LOG_DIR": str(tmp_path / "new"), "ROS_SECURITY_ENABLE": "false"}
    check_ros_environment({**usual, "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp"})
    check_ros_environment({"RMW_IMPLEMENTATION": ""})


@pytest.mark.parametrize("home", ["/proc/nohome", "/dev/null", ""])
def test_without_a_home_the_logs_of_ros_have_a_place_all_the_same(tmp_path, monkeypatch, home):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    environ = node_environment({"HOME": home}, domain_id=0, discovery="localhost")
    assert environ["ROS_LOG_DIR"] == str(tmp_path / f"shoal-{os.getuid()}" / "log")
    assert log_folder({"HOME": str(tmp_path)}) == {}


def test_a_temporary_folder_of_somebody_else_is_not_used(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    trap = tmp_path / f"shoal-{os.getuid()}"
    for make in (trap.touch, lambda: trap.symlink_to(tmp_path), lambda: trap.mkdir(mode=0o777)):
        make()
        if trap.is_dir() and not trap.is_symlink():
            trap.chmod(0o777)
        folder = private_folder()
        assert folder != trap
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
        trap.rmdir() if trap.is_dir() and not trap.is_symlink() else trap.unlink()
    assert private_folder() == private_folder() == trap
    assert stat.S_IMODE(trap.stat().st_mode) == 0o700


@pytest.mark.ros
@pytest.mark.parametrize("command", ["run", "replay", "topic"])
def test_every_command_with_nodes_refuses_before_it_writes_anything(command, tmp_path):
    words = {
        "run": ["run", "--out", str(tmp_path / "r")],
        "replay": ["replay", "."],
        "topic": ["topic", "list"],
    }
    module, *arguments = words[command]
    done = subprocess.run(
        ["python", "-P", "-m", f"auv_bringup.tools.{module}", *arguments],
        env={**os.environ, "ROS_LOG_DIR": "/proc/nolog"},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    if command != "replay":  # which looks for its bag first
        assert "ROS_LOG_DIR" in done.stderr
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert list(tmp_path.iterdir()) == []
