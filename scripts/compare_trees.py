"""Command `./scripts/compare_trees`: compare the bags of two checkouts byte by byte.

Each checkout flies with its own environment, in a separate process. Where the files differ, the new checkout
compares their messages: a bag also holds the definitions of its messages, comments included.
"""

from __future__ import annotations

import argparse
import hashlib
import resource
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import NamedTuple, NoReturn

SCENARIOS = (
    "flock_acoustic",
    "flock_drift",
    "flock_modem",
    "medium_access",
    "range_sweep",
    "ch2_pfapd_obstacles_corrected",
    "ch3_circle_corrected",
    "ch4_region",
    "ch5_communication_obstacles",
    "ch6_obstacles",
    "compare_path_laws",
)
"""Scenarios with different laws, channels, navigations and media."""
EQUAL, DIFFERENT, REFUSED = 0, 1, 2
_FLOWN = (0, 4)
"""
Exit statuses of a flight of full length: 4 means that hulls touched, which some laws of the thesis allow.
"""
_LIMIT_S = 900.0
_COMPARE = """
import sys
from pathlib import Path

from auv_bag.compare import compare_bags

for line in compare_bags(Path(sys.argv[1]), Path(sys.argv[2])):
    print(line)
"""

_EPILOG = """\
exit status:
  0    all bags are equal, or differ in the text of message definitions only
  1    some messages differ
  2    bad input, or a checkout does not fly a scenario

examples:
  ./scripts/compare_trees ../before .
  ./scripts/compare_trees ../before . --scenarios flock_acoustic --duration 200 --rounds 5
"""


class _OneLineParser(argparse.ArgumentParser):
    """A parser whose errors are one line, as in the other commands."""

    def error(self, message: str) -> NoReturn:
        """End the program with an error line."""
        self.exit(REFUSED, f"error: {message} ({self.prog} --help says more)\n")


class Flown(NamedTuple):
    """The result of one flight: its bag, the hash of its file, the processor time of its command (s)."""

    bag: Path
    sha256: str
    cpu_s: float


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status."""
    options = _parse(argv)
    equal = True
    with tempfile.TemporaryDirectory(prefix="compare_trees_") as scratch:
        for name in options.scenarios:
            ratios = []
            for number in range(options.rounds):
                old, new = (
                    _fly(tree, name, options, Path(scratch) / f"{side}_{name}_{number}")
                    for side, tree in (("old", options.old), ("new", options.new))
                )
                ratios.append(new.cpu_s / old.cpu_s)
                is_same = old.sha256 == new.sha256
                differences = [] if is_same else _differences(options.new, old.bag, new.bag)
                equal &= not differences
                verdict = "DIFFERENT" if differences else "equal" if is_same else "equal messages"
                print(f"{name}: {verdict}  {old.sha256[:16]}  {new.sha256[:16]}", flush=True)
                print("".join(f"    {line}\n" for line in differences), end="", flush=True)
            print(
                f"{name}: processor time of new over old: {median(ratios):.2f}, {len(ratios)} pairs",
                flush=True,
            )
    return EQUAL if equal else DIFFERENT


def _parse(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = _OneLineParser(
        prog="./scripts/compare_trees",
        description="Fly scenarios in lock-step in two checkouts, and compare the files of their bags.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("old", type=_checkout, metavar="OLD", help="folder of a checkout")
    parser.add_argument("new", type=_checkout, metavar="NEW", help="folder of the other one")
    parser.add_argument(
        "--scenarios", nargs="+", default=SCENARIOS, metavar="NAME", help=f"default: {' '.join(SCENARIOS)}"
    )
    parser.add_argument("--duration", type=float, default=60.0, metavar="S", help="length of a flight (60)")
    parser.add_argument("--layout", default="single", choices=("node", "vehicle", "single"))
    parser.add_argument(
        "--rounds", type=int, default=1, metavar="N", help="fly each so many times, in turn (1)"
    )
    return parser.parse_args(argv)


def _checkout(text: str) -> Path:
    folder = Path(text).resolve()
    if not (folder / "scripts" / "run").is_file():
        raise argparse.ArgumentTypeError(f"'{text}': allowed: a checkout with scripts/run in it")
    return folder


def _fly(tree: Path, name: str, options: argparse.Namespace, out: Path) -> Flown:
    """Fly a scenario with one checkout."""
    command = [str(tree / "scripts" / "run"), name, "--mode", "lockstep", "--layout", options.layout]
    command += ["--duration", f"{options.duration:g}", "--no-figures", "--out", str(out)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, capture_output=True, text=True, timeout=_LIMIT_S, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    bags = sorted(out.glob("**/*.mcap"))
    if done.returncode not in _FLOWN or len(bags) != 1:
        _refuse(tree, f"{name} was not flown, status {done.returncode}", done.stderr)
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Flown(bags[0].parent, hashlib.sha256(bags[0].read_bytes()).hexdigest(), cpu_s)


def _differences(tree: Path, old: Path, new: Path) -> list[str]:
    """Return a line for each topic whose messages differ; both bags are read with one checkout."""
    activated = 'source "$0/scripts/activate.bash" && exec python -P -c "$@"'
    command = ["bash", "-c", activated, str(tree), _COMPARE, str(old), str(new)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=_LIMIT_S, check=False)
    if done.returncode:
        _refuse(tree, "the bags were not compared", done.stderr)
    return done.stdout.splitlines()


def _refuse(tree: Path, what: str, errors: str) -> NoReturn:
    """End the program with an error line, whose end is the last line of a command's errors."""
    last = (errors.strip().splitlines() or ["it said nothing"])[-1]
    sys.stderr.write(f"error: {tree}: {what}: {last}\n")
    raise SystemExit(REFUSED)


if __name__ == "__main__":
    raise SystemExit(main())
