"""The command line of `./scripts/replay`."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

from auv_core.cli.one_line_parser import OneLineParser, read_argument

DEFAULT_CLOCK_HZ = 40.0
DEFAULT_DELAY_S = 1.0

_EPILOG = """\
A recorded /clock is published unchanged, unless --clock makes a new one.

exit status:
  0    done
  1    --re-estimate gives estimates that differ from the recorded ones
  2    bad input
  3    internal error
  130  Ctrl-C

examples:
  ./scripts/replay results/flock_acoustic-1-lockstep --rate 10
  ./scripts/replay results/flock_acoustic-1-lockstep --start 300 --clock
  ./scripts/replay results/flock_acoustic-1-lockstep --re-estimate
"""


def parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = OneLineParser(
        prog="./scripts/replay",
        description="Publish a recorded bag again, with the recorded types, QoS and timing.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "bag", type=Path, metavar="BAG", help="bag folder, or results folder with a bag in it"
    )
    parser.add_argument(
        "--rate", type=_number_of(0.001, 1e6), default=1.0, metavar="R", help="speed, 1 is as recorded"
    )
    parser.add_argument(
        "--start",
        type=_number_of(0.0, 1e9),
        default=0.0,
        metavar="S",
        help="start this many seconds into the bag",
    )
    parser.add_argument(
        "--clock",
        type=_number_of(0.01, 10_000.0),
        nargs="?",
        const=DEFAULT_CLOCK_HZ,
        metavar="HZ",
        help=f"make a /clock from the time of the bag, at this rate (Hz, wall time; {DEFAULT_CLOCK_HZ:g})",
    )
    parser.add_argument(
        "--delay",
        type=_number_of(0.0, 3600.0),
        default=DEFAULT_DELAY_S,
        metavar="S",
        help=f"wall seconds before the first message, for discovery of readers ({DEFAULT_DELAY_S:g})",
    )
    parser.add_argument("--topics", nargs="+", default=[], metavar="T", help="publish these topics only")
    parser.add_argument(
        "--discovery",
        choices=("localhost", "subnet"),
        default="localhost",
        help="which machines can receive it: this one (default), or the whole subnet",
    )
    parser.add_argument(
        "--re-estimate",
        action="store_true",
        help="do not publish: run the neighbour filters again from the recorded packets and compare",
    )
    return parser.parse_args(argv)


def _number_of(least: float, most: float) -> Callable[[str], float]:
    """Return the type function of an argument that is a number between two bounds."""
    allowed = f"a number from {least:g} to {most:g}"
    return lambda text: read_argument(text, float, lambda value: least <= value <= most, allowed)
