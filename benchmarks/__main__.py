"""
Measure everything in one run and print one table: each value, its comparison value, and their ratio.

    source scripts/activate.bash && python -m benchmarks [--only PART] [--peers] [--quick]

Machines are noisy: compare ratios, which come from alternating blocks. The table is also written to
results/benchmarks as Markdown and JSON. docs/reference/performance.md explains what is measured and what is
not.
"""

from __future__ import annotations

import argparse
import dataclasses
import importlib
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from auv_core.cli.one_line_parser import OneLineParser

PARTS = {"kernel": "kernel", "torpedo": "torpedo", "inprocess": "inprocess", "ros": "ros_lockstep"}
BESIDE_PEERS = ("kernel", "torpedo")
ONE_THREAD = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
HEADS = ("figure", "measured", "beside", "ratio", "bar", "kept")

_EPILOG = """\
examples:
  python -m benchmarks                     everything
  python -m benchmarks --only kernel       one part
  python -m benchmarks --quick             check that everything works
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print and write the table; return the exit status."""
    found = [name for name, module in PARTS.items() if Path(__file__).with_name(f"{module}.py").exists()]
    parser = OneLineParser(
        prog="python -m benchmarks",
        description=__doc__,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--only", choices=found, help="measure one part")
    parser.add_argument(
        "--peers", action="store_true", help="install the peers if they are missing, and measure them"
    )
    parser.add_argument(
        "--quick", action="store_true", help="short blocks, which only check that everything works"
    )
    parser.add_argument("--out", type=Path, default=Path("results/benchmarks"), help="folder of the files")
    options = parser.parse_args(arguments)
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    rows = _measured([options.only] if options.only else found, options)
    print(_markdown(rows))
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "benchmarks.md").write_text(_markdown(rows) + "\n", encoding="utf-8")
    (options.out / "benchmarks.json").write_text(json.dumps(rows, indent=2) + "\n", encoding="utf-8")
    return 0


def _measured(parts: Sequence[str], options: argparse.Namespace) -> list[dict[str, Any]]:
    """Return the rows of some parts, and report progress."""
    rows: list[dict[str, Any]] = []
    for part in parts:
        module = importlib.import_module(f"benchmarks.{PARTS[part]}")
        more = {}
        if part in BESIDE_PEERS and options.peers:
            more["peers"] = importlib.import_module("benchmarks.peers").peers_python()
        print(f"{part} ...", file=sys.stderr, flush=True)
        for row in module.rows(quick=options.quick, **more):
            print(f"{part}: {row.figure}: {row.value}  {row.ratio}", file=sys.stderr, flush=True)
            rows.append({"part": part, **dataclasses.asdict(row)})
    return rows


def _markdown(rows: Sequence[dict[str, Any]]) -> str:
    """Return the rows as a Markdown table."""
    lines = [HEADS, tuple("---" for _ in HEADS)]
    for row in rows:
        kept = {None: "", True: "yes", False: "NO"}[row.get("kept")]
        lines.append((row["figure"], row["value"], row["limit"], row["ratio"], row.get("bar", ""), kept))
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


if __name__ == "__main__":
    raise SystemExit(main())
