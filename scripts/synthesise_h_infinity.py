"""Command that computes the H-infinity feedback for thesis Table 2.1 and writes its preset."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from auv_control.synthesis.h_infinity import Weights, preset_axes, preset_file, preset_text
from auv_core.cli.one_line_parser import OneLineParser

_HELP = """\
Compute the gains of the h_infinity path-following law for the vehicle of thesis Table
2.1: the smallest gain from disturbing force to errors and effort by bisection, the
feedback for slightly more than that, and the norm of the closed loop, computed in two
ways without the Riccati equation.
"""

_EPILOG = """\
exit status:
  0    done
  1    --check: the preset differs from the computed one
  2    bad input; nothing was written

examples:
  ./scripts/synthesise_h_infinity            compute the gains, write the preset
  ./scripts/synthesise_h_infinity --check    compute them, compare with the preset
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Compute, report and write, or compare with the preset; return the exit status."""
    parser = OneLineParser(
        prog="./scripts/synthesise_h_infinity",
        description=_HELP,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--check", action="store_true", help="write nothing; fail if the preset differs")
    is_check = parser.parse_args(arguments).check
    weights = Weights()
    axes = preset_axes(weights)
    for name, axis in zip(("surge", "sway"), axes, strict=True):
        q, e, v = axis.gain[0]
        print(f"{name}: F = [{q:.2f} N/(m s), {e:.2f} N/m, {v:.2f} N s/m]")
        print(f"  gamma: smallest {axis.gamma_best:.6f}, chosen {axis.gamma:.6f}")
        print(f"  norm of the loop: {axis.norm_hamiltonian:.6f} by its Hamiltonian matrix, ", end="")
        print(f"{axis.norm_sweep:.6f} by a sweep of frequencies")
    text, file = preset_text(weights, axes), preset_file()
    if is_check:
        is_same = file.is_file() and file.read_text(encoding="utf-8") == text
        print(f"{file.name}: {'as computed' if is_same else 'differs from the computed preset'}")
        return 0 if is_same else 1
    file.write_text(text, encoding="utf-8")
    print(f"written: {file}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
