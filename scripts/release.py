"""
Command `./scripts/release`: give every file that states a version the same one, and release the changelog.

The packages have one version and one changelog. Their CHANGELOG.rst is what catkin_pkg and bloom read; what
is not released yet comes under `Forthcoming`. It needs nothing but Python.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

ROOT = Path(__file__).resolve().parents[1]
VERSION = re.compile(r"## \[(\d+\.\d+\.\d+)\] - (\d{4}-\d{2}-\d{2})")
UNRELEASED = "## [Unreleased]"
BAD_INPUT = 2
STATED = {
    "src/*/package.xml": re.compile(r"(?<=<version>)[^<]+(?=</version>)"),
    "src/*/setup.py": re.compile(r'(?<=version=")[^"]+(?=")'),
    "src/shoal/shoal/__init__.py": re.compile(r'(?<=__version__ = ")[^"]+(?=")'),
    "CITATION.cff": re.compile(r"(?<=^version: )\S+", re.MULTILINE),
}
"""Which files state the version, and where in them."""

_EPILOG = """\
exit status:
  0    done
  2    bad input; nothing was written

examples:
  ./scripts/release 0.2.0 2026-03-01    version and changelog of a release
  ./scripts/release                     CHANGELOG.rst of the packages only
"""


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
    if line.strip() == UNRELEASED:
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
        return _escaped(text)  # code that continues in the next line
    return "".join(f"``{piece}``" if k % 2 else _escaped(piece) for k, piece in enumerate(pieces))


def _escaped(text: str) -> str:
    return re.sub(r"([*_|`\\])", r"\\\1", text)


def stated_versions(root: Path) -> dict[str, str]:
    """Return the version that each file states, by the file's name."""
    return {
        str(path.relative_to(root)): found[0]
        for pattern, stated in STATED.items()
        for path in sorted(root.glob(pattern))
        if (found := stated.search(path.read_text(encoding="utf-8")))
    }


def set_version(root: Path, version: str) -> None:
    """Write a version into every file that states it."""
    for pattern, stated in STATED.items():
        for path in sorted(root.glob(pattern)):
            text = path.read_text(encoding="utf-8")
            path.write_text(stated.sub(version, text, count=1), encoding="utf-8")


def released(markdown: str, version: str, date: str) -> str:
    """
    Return a changelog whose unreleased entries are those of a version, with a new empty section above.

    Raises
    ------
    ChangelogError
        If the changelog has no unreleased section.

    """
    if UNRELEASED not in markdown:
        raise ChangelogError(f"CHANGELOG.md: {UNRELEASED} is missing; allowed: a changelog with that heading")
    return markdown.replace(UNRELEASED, f"{UNRELEASED}\n\n## [{version}] - {date}", 1)


class _OneLineParser(argparse.ArgumentParser):
    """A parser whose errors are one line, as in the other commands."""

    def error(self, message: str) -> NoReturn:
        """End the program with an error line."""
        self.exit(BAD_INPUT, f"error: {message} ({self.prog} --help says more)\n")


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = _OneLineParser(
        prog="./scripts/release",
        description="Write VERSION into every file that states it, give the unreleased entries of\n"
        "CHANGELOG.md that version and DATE, and write the CHANGELOG.rst of every package.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("version", nargs="?", metavar="VERSION", help="like 0.2.0")
    parser.add_argument("date", nargs="?", metavar="DATE", help="like 2026-03-01")
    options = parser.parse_args(arguments)
    given = f"{options.version or ''} {options.date or ''}".strip()
    if given and not re.fullmatch(r"\d+\.\d+\.\d+ \d{4}-\d{2}-\d{2}", given):
        parser.error(f"'{given}' is not allowed; allowed: a version and a date, like 0.2.0 2026-03-01")
    return options


def main(arguments: Sequence[str] | None = None, root: Path = ROOT) -> int:
    """Write the files; return the exit status."""
    options = _parse(arguments)
    changelog = root / "CHANGELOG.md"
    markdown = changelog.read_text(encoding="utf-8")
    try:
        if options.version:
            markdown = released(markdown, options.version, options.date)
        texts = {
            manifest.parent / "CHANGELOG.rst": changelog_rst(manifest.parent.name, markdown)
            for manifest in sorted(root.glob("src/*/package.xml"))
        }
    except ChangelogError as error:
        sys.stderr.write(f"error: {error}\n")
        return BAD_INPUT
    if options.version:
        set_version(root, options.version)
        changelog.write_text(markdown, encoding="utf-8")
    for path, text in texts.items():
        path.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
