"""Checks of the user's ROS 2 environment, before anything is started."""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Mapping
from pathlib import Path

from auv_core.params import ConfigError, shown

_NO_MIDDLEWARE = "rmw_implementation"
"""The package that loads a middleware is in the same list."""


def check_ros_environment(environ: Mapping[str, str]) -> None:
    """
    Raise ConfigError, one line, for a variable of ROS 2 with which no node can start on this machine.

    It reads the ament index, so ROS 2 must be installed.
    """
    from ament_index_python import get_resources

    wanted = environ.get("RMW_IMPLEMENTATION", "")
    installed = sorted(set(get_resources("rmw_typesupport")) - {_NO_MIDDLEWARE})
    if wanted and wanted not in installed:
        raise ConfigError(
            f"RMW_IMPLEMENTATION: {shown(wanted)} is not installed here; allowed: {' or '.join(installed)}"
        )
    if environ.get("ROS_SECURITY_ENABLE", "").lower() == "true":
        raise ConfigError(
            "ROS_SECURITY_ENABLE: 'true' is not allowed, since the nodes of a run have no security enclaves; "
            "allowed: 'false' or nothing"
        )
    for name, folder in (("ROS_LOG_DIR", ""), ("ROS_HOME", "log")):
        if environ.get(name) and not _can_be_written(Path(environ[name]).expanduser() / folder):
            raise ConfigError(
                f"{name}: {shown(environ[name])} cannot be written; allowed: a writable folder, or unset"
            )


def log_folder(environ: Mapping[str, str]) -> dict[str, str]:
    """
    Return the variable that sends the logs of ROS 2 to a temporary folder; {} if their folder is writable.
    """
    if environ.get("ROS_LOG_DIR") or environ.get("ROS_HOME"):
        return {}
    home = environ.get("HOME", "")
    if home and _can_be_written(Path(home) / ".ros" / "log"):
        return {}
    return {"ROS_LOG_DIR": str(private_folder() / "log")}


def private_folder() -> Path:
    """Return a folder for temporary files in which only this user can write."""
    folder = Path(tempfile.gettempdir()) / f"shoal-{os.getuid()}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
        if stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o077:
            return folder
    except OSError:
        pass  # it belongs to another user, or is no folder
    return Path(tempfile.mkdtemp(prefix="shoal-"))


def _can_be_written(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK | os.X_OK)
