"""`shoal run | sweep | reproduce | replay | topic`: the commands of Shoal under one name."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Sequence
from typing import NamedTuple

from auv_core.cli.failures import BAD_INPUT, DONE
from auv_core.cli.one_line_parser import call_commands, fail
from auv_core.params import shown
from shoal import __version__


class _Command(NamedTuple):
    module: str
    words: str
    needs_ros: bool = False


COMMANDS = {
    "run": _Command("auv_bringup.tools.run", "fly a scenario, then report the result"),
    "sweep": _Command("auv_experiment.sweeps.cli", "fly a grid or a sample of scenarios with many seeds"),
    "reproduce": _Command("auv_thesis.cli", "repeat the figures, tables and claims of the thesis"),
    "replay": _Command("auv_bringup.tools.replay", "publish a recorded bag again", needs_ros=True),
    "topic": _Command("auv_bringup.tools.topic", "inspect the topics of a running flock", needs_ros=True),
}
_HELP_WORDS = ("-h", "--help")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return its exit status."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    name = words[0] if words else "--help"
    if name in _HELP_WORDS:
        sys.stdout.write(_help())
        return DONE
    if name == "--version":
        sys.stdout.write(f"shoal {__version__}\n")
        return DONE
    if name not in COMMANDS:
        return fail(BAD_INPUT, f"command: {shown(name)} is not allowed; allowed: {', '.join(COMMANDS)}")
    call_commands("shoal ")
    command = COMMANDS[name]
    if command.needs_ros and importlib.util.find_spec("rclpy") is None and not set(_HELP_WORDS) & set(words):
        needed = "allowed: with ROS 2 Jazzy and the workspace sourced"
        return fail(BAD_INPUT, f"shoal {name}: rclpy cannot be imported; {needed}")
    status: int = importlib.import_module(command.module).main(words[1:])
    return status


def _help() -> str:
    width = max(map(len, COMMANDS))
    lines = [f"  {name:<{width}}  {command.words}" for name, command in COMMANDS.items()]
    return "\n".join(
        [
            "usage: shoal COMMAND [ARGUMENT...]; shoal COMMAND --help says more",
            "",
            "Groups of underwater vehicles that communicate only through water.",
            "",
            *lines,
            "",
            "  --version  print the version",
            "",
            "In Python: import shoal",
            "",
        ]
    )


if __name__ == "__main__":
    sys.exit(main())
