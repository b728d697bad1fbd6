"""
The start of a node process: command line, parameters files, environment.

The launcher and the launch file both use this, so that a node gets the same settings from either. This
module does not import ROS.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping, MutableMapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from auv_bringup.launching.ros_environment import log_folder
from auv_core.machine.whole_files import write_text

if TYPE_CHECKING:
    from auv_bringup.launching.layout import ProcessSpec
    from auv_bringup.launching.node_specs import NodeSpec

# One vehicle's matrices are small: threads of the linear algebra would only compete for the cores.
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
CONTAINER_MODULE = "auv_bringup.nodes.node_container"
PROFILES, LOCAL_PROFILES = "fastdds.xml", "fastdds_localhost.xml"


@dataclass(frozen=True)
class Part:
    """One module of nodes, with the namespace and the parameters file of its nodes."""

    module: str
    namespace: str
    params_file: str


def parts_of(process: ProcessSpec, params_dir: Path) -> list[Part]:
    """Write the parameters of the nodes of a process; return the arguments of its container."""
    return [
        Part(node.module, node.namespace, str(write_params_file(node, params_dir))) for node in process.nodes
    ]


def container_arguments(parts: Sequence[Part]) -> list[str]:
    """Return the arguments of a node container."""
    return [word for part in parts for word in ("--node", part.module, part.namespace, part.params_file)]


def command_line(parts: Sequence[Part]) -> list[str]:
    """Return the command that starts a process with the current Python."""
    return [sys.executable, "-P", "-m", CONTAINER_MODULE, *container_arguments(parts)]


def log_name(name: str) -> str:
    """Return the file name without suffix of a node or process: auv_1.agent_node for /auv_1/agent_node."""
    return name.strip("/").replace("/", ".")


def adopt(environ: Mapping[str, str], own: MutableMapping[str, str] = os.environ) -> None:
    """Replace the environment of this process; DDS reads it when the first participant is made."""
    for name in set(own) - set(environ):
        del own[name]
    own.update(environ)


def write_params_file(spec: NodeSpec, folder: Path) -> Path:
    """Write the parameters of a node as ROS 2 reads them, and return the file."""
    # The relay's process has two nodes, relay and clock: its parameters are for both.
    key = "/**" if spec.role == "relay" else spec.name
    path = folder / f"{log_name(spec.name)}.yaml"
    # JSON is YAML with all texts in quotes: without them ROS reads a vehicle called `y` as true.
    write_text(path, json.dumps({key: {"ros__parameters": spec.params}}, indent=2) + "\n")
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
        'localhost' keeps ROS traffic on this machine. It overrides the user's environment, except for a
        profiles file of Fast DDS, which also sets the transports. 'subnet' allows traffic on the network.

    """
    result = dict(environ)
    result.pop("ROS_LOCALHOST_ONLY", None)  # the old variable; it would override the new one
    if discovery == "localhost":
        result.pop("ROS_STATIC_PEERS", None)
        result.pop("ROS_DISCOVERY_SERVER", None)
    result.update(
        ROS_DOMAIN_ID=str(domain_id),
        ROS_AUTOMATIC_DISCOVERY_RANGE=discovery.upper(),
        PYTHONUNBUFFERED="1",
        RCUTILS_COLORIZED_OUTPUT="0",
        **ONE_THREAD,
        **log_folder(environ),
    )
    if own_profiles(environ) is None:
        is_closed = discovery == "localhost" and "fastrtps" in environ.get("RMW_IMPLEMENTATION", "fastrtps")
        profiles = LOCAL_PROFILES if is_closed else PROFILES
        result["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(config_file(profiles))
        if is_closed:  # the file sets everything, and closes what LOCALHOST leaves open
            result["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SYSTEM_DEFAULT"
    return result


def own_profiles(environ: Mapping[str, str]) -> str | None:
    """Return the user's profiles file of Fast DDS, None without one."""
    ours = {str(config_file(name)) for name in (PROFILES, LOCAL_PROFILES)}
    names = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
    return next((environ[name] for name in names if name in environ and environ[name] not in ours), None)


def reach_notes(environ: Mapping[str, str], discovery: str) -> list[str]:
    """Return notes for the user on which machines can reach a run, one line each."""
    if discovery == "subnet":
        return ["discovery subnet: every machine on this network sees the run and can send it ROS messages"]
    profiles = own_profiles(environ)
    if profiles is None:
        return []
    return [f"note: Fast DDS uses {profiles}; this file decides whether traffic stays on this machine"]


def export_line(domain_id: int, discovery: str) -> str:
    """Return the shell command after which the user's own ROS 2 tools see a run."""
    return f"export ROS_DOMAIN_ID={domain_id} ROS_AUTOMATIC_DISCOVERY_RANGE={discovery.upper()}"


def config_file(name: str) -> Path:
    """Return a file of this package's config folder, in the source tree or where the package is installed."""
    here = Path(__file__).resolve()
    candidates = [here.parents[2] / "config" / name]
    candidates += [parent / "share" / "auv_bringup" / "config" / name for parent in Path(__file__).parents]
    for candidate in candidates:
        if candidate.is_file():
            return candidate
    raise FileNotFoundError(f"{name}: not in the config folder of auv_bringup")
