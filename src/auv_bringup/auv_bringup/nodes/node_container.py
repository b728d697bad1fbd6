"""
Process of several nodes, like ROS 2's component container, but with all nodes from the start.

    ros2 run auv_bringup node_container --node MODULE NAMESPACE PARAMS_FILE [--node ...]
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module

from rclpy.node import Node
from rclpy.utilities import remove_ros_args

from auv_bringup.launching.node_start import Part
from auv_core.cli.one_line_parser import OneLineParser
from auv_ros.lifecycle import main_loop

_GLOBAL_ARGUMENTS = ("--ros-args", "--disable-external-lib-logs")
"""The log of a process is its output; ROS keeps a second log elsewhere unless disabled."""
MOST_WITH_SERVICES = 64
"""A process with more nodes has no services for parameters and types: they take most of the start-up time."""


def run(parts: Sequence[Part]) -> int:
    """Run the nodes of all parts in this process; return the exit status."""
    with_services = len(parts) <= MOST_WITH_SERVICES
    return main_loop(
        lambda: [node for part in parts for node in _make(part, with_services=with_services)],
        _GLOBAL_ARGUMENTS,
    )


def _make(part: Part, *, with_services: bool) -> Sequence[Node]:
    arguments = ["--ros-args", "--params-file", part.params_file]
    if not with_services:
        arguments += ["-p", "start_type_description_service:=false"]
    nodes: Sequence[Node] = import_module(part.module).make_nodes(
        namespace=part.namespace, cli_args=arguments, start_parameter_services=with_services
    )
    return nodes


def main() -> None:
    """Run the nodes in the command line."""
    parser = OneLineParser(prog="node_container", description=__doc__.splitlines()[1])
    parser.add_argument(
        "--node",
        action="append",
        nargs=3,
        required=True,
        metavar=("MODULE", "NAMESPACE", "PARAMS_FILE"),
        help="a module with make_nodes, and namespace and parameters of its nodes; repeatable",
    )
    options = parser.parse_args(remove_ros_args(sys.argv)[1:])
    raise SystemExit(run([Part(*words) for words in options.node]))


if __name__ == "__main__":
    main()
