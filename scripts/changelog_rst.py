"""
Write CHANGELOG.rst of every package from CHANGELOG.md, in the form that catkin_pkg and bloom read.

    python3 scripts/changelog_rst.py

Run at a release, after `## [Unreleased]` in CHANGELOG.md has got its version and date. The packages have one
version and one changelog. What is not released yet comes under `Forthcoming`.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
VERSION = re.compile(r"## \[(\d+\.\d+\.\d+)\] - (\d{4}-\d{2}-\d{2})")


class ChangelogError(ValueError):
    """A changelog with a line that has no place in it."""


def changelog_rst(package: str, markdown: str) -> str:
    """
    Return the CHANGELOG.rst of a package.

    Raises
    ------
    ChangelogError
        For a heading of a version that is neither ``[Unreleased]`` nor ``[1.2.3] - 2026-01-31``.

    """
    title = f"Changelog for package {package}"
    out = ["^" * len(title), title, "^" * len(title)]
    for line in markdown.splitlines():
        if line.startswith("## "):
            heading = _version_heading(line)
            out += ["", heading, "-" * len(heading)]
        elif line.startswith("### "):
            out += ["", f"* {line[4:].strip()}", ""]
        elif line.startswith("- "):
            out.append(f"  * {_inline(line[2:])}")
        elif line.startswith("  "):
            out.append(f"    {_inline(line.strip())}")
    return "\n".join(out) + "\n"


def _version_heading(line: str) -> str:
    if line.strip() == "## [Unreleased]":
        return "Forthcoming"
    match = VERSION.fullmatch(line.strip())
    if match is None:
        raise ChangelogError(
            f"CHANGELOG.md: {line!r} is not allowed; allowed: ## [Unreleased], ## [1.2.3] - 2026-01-31"
        )
    return f"{match[1]} ({match[2]})"


def _inline(text: str) -> str:
    """Return a line with the code and the links of Markdown as those of reStructuredText."""
    text = re.sub(r"\[([^\]]+)\]\((https?://[^)]+)\)", r"\1 (\2)", text)
    text = re.sub(r"\[([^\]]+)\]\([^)]+\)", r"\1", text)
    pieces = text.split("`")
    if len(pieces) % 2 == 0:
        return _escaped(text)  # code that goes on in the next line
    return "".join(f"``{piece}``" if k % 2 else _escaped(piece) for k, piece in enumerate(pieces))


def _escaped(text: str) -> str:
    return re.sub(r"([*_|`\\])", r"\\\1", text)


def main() -> int:
    """Write the files; return the exit status."""
    markdown = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    try:
        for manifest in sorted(ROOT.glob("src/*/package.xml")):
            folder = manifest.parent
            (folder / "CHANGELOG.rst").write_text(changelog_rst(folder.name, markdown), encoding="utf-8")
    except ChangelogError as error:
        sys.stderr.write(f"error: {error}\n")
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
