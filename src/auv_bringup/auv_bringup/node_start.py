"""
How a node process is started: its command line, its parameters file, its environment.

The launcher and the launch file both use this, so that a node gets the same from either. No ROS is imported
here.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from auv_bringup.compose import NodeSpec


def command_line(spec: NodeSpec, params_file: Path) -> list[str]:
    """Return the command that starts a node with the Python that runs this."""
    namespace = [] if spec.namespace == "/" else ["-r", f"__ns:={spec.namespace}"]
    # The log of a node is what it prints; ROS keeps a second one elsewhere unless told not to.
    ros_arguments = ["--disable-external-lib-logs", *namespace, "--params-file", str(params_file)]
    return [sys.executable, "-m", spec.module, "--ros-args", *ros_arguments]


def log_name(spec: NodeSpec) -> str:
    """Return a node's file name without suffix: auv_1.agent_node for /auv_1/agent_node."""
    return spec.name.strip("/").replace("/", ".")


def write_params_file(spec: NodeSpec, folder: Path) -> Path:
    """Write the parameters of a node as ROS 2 reads them, and return the file."""
    # The relay's process holds two nodes, relay and clock: what it is given is for both.
    key = "/**" if spec.role == "relay" else spec.name
    path = folder / f"{log_name(spec)}.yaml"
    # JSON is YAML with every word in quotes: without them ROS reads a vehicle called `y` as true.
    path.write_text(json.dumps({key: {"ros__parameters": spec.params}}, indent=2) + "\n", encoding="utf-8")
    return path


def node_environment(environ: Mapping[str, str], *, domain_id: int, discovery: str) -> dict[str, str]:
    """
    Return the environment of a node.

    Parameters
    ----------
    environ : mapping
        Environment of the user.
    domain_id : int
        ROS domain.
    discovery : str
        'localhost' keeps ROS traffic on this machine, whatever the user's environment says; 'subnet' lets
        it out.

    """
    result = dict(environ)
    result.pop("ROS_LOCALHOST_ONLY", None)  # the old word for it; it would override the new one
    if discovery == "localhost":
        result.pop("ROS_STATIC_PEERS", None)
        result.pop("ROS_DISCOVERY_SERVER", None)
    result.update(
        ROS_DOMAIN_ID=str(domain_id),
        ROS_AUTOMATIC_DISCOVERY_RANGE=discovery.upper(),
        PYTHONUNBUFFERED="1",
        RCUTILS_COLORIZED_OUTPUT="0",
        # One vehicle's matrices are small: threads of the linear algebra would only fight over the cores.
        OMP_NUM_THREADS="1",
        OPENBLAS_NUM_THREADS="1",
        MKL_NUM_THREADS="1",
    )
    if not ("FASTRTPS_DEFAULT_PROFILES_FILE" in environ or "FASTDDS_DEFAULT_PROFILES_FILE" in environ):
        result["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(config_file("fastdds.xml"))
    return result


def export_line(domain_id: int, discovery: str) -> str:
    """Return the shell command after which the user's own ROS 2 tools see a run."""
    return f"export ROS_DOMAIN_ID={domain_id} ROS_AUTOMATIC_DISCOVERY_RANGE={discovery.upper()}"


def config_file(name: str) -> Path:
    """Return a file of this package's config folder, in the source tree or where the package is installed."""
    here = Path(__file__).resolve()
    candidates = [here.parents[1] / "config" / name]
    candidates += [parent / "share" / "auv_bringup" / "config" / name for parent in Path(__file__).parents]
    for candidate in candidates:
        if candidate.is_file():
            return candidate
    raise FileNotFoundError(f"{name}: not in the config folder of auv_bringup")
