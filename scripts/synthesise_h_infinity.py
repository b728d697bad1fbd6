"""Command that computes the gains of the H-infinity laws and writes their presets."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from auv_control.synthesis.designs import Design, designs
from auv_core.cli.one_line_parser import OneLineParser

_HELP = """\
Compute the gains of the H-infinity laws: h_infinity for the vehicle of thesis Table 2.1,
formation_h_infinity for that of Table 3.1, velocity_h_infinity for ODIN. Each needs the
smallest gain from disturbing force to errors and effort by bisection, the feedback for
slightly more than that, and the norm of the closed loop, computed in two ways without
the Riccati equation.
"""

_EPILOG = """\
exit status:
  0    done
  1    --check: a preset differs from the computed one
  2    bad input; nothing was written

examples:
  ./scripts/synthesise_h_infinity            compute the gains, write the presets
  ./scripts/synthesise_h_infinity --check    compute them, compare with the presets
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Compute, report and write, or compare with the preset; return the exit status."""
    parser = OneLineParser(
        prog="./scripts/synthesise_h_infinity",
        description=_HELP,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--check", action="store_true", help="write nothing; fail if a preset differs")
    is_check = parser.parse_args(arguments).check
    return max([_finished(design, is_check=is_check) for design in designs()])


def _finished(design: Design, *, is_check: bool) -> int:
    """Report one design and write its preset, or compare with it; return the exit status."""
    print(f"{design.preset}:")
    for name, axis in design.axes.items():
        print(f"  {name}: F = [{', '.join(f'{gain:.2f}' for gain in axis.gain[0])}]")
        print(f"    gamma: smallest {axis.gamma_best:.6f}, chosen {axis.gamma:.6f}")
        print(f"    norm of the loop: {axis.norm_hamiltonian:.6f} by its Hamiltonian matrix, ", end="")
        print(f"{axis.norm_sweep:.6f} by a sweep of frequencies")
    if is_check:
        is_same = design.file.is_file() and design.file.read_text(encoding="utf-8") == design.text
        print(f"  {design.file.name}: {'as computed' if is_same else 'differs from the computed preset'}")
        return 0 if is_same else 1
    design.file.write_text(design.text, encoding="utf-8")
    print(f"  written: {design.file}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
