"""Every command, with what its --help says."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

_OTHERS = {
    "shoal": [sys.executable, "-P", "-m", "shoal.commands"],
    "python -m benchmarks": [sys.executable, "-m", "benchmarks"],
}
_RUNS_PYTHON = re.compile(r"^exec python3? -P (-m \S+|\"\$\(dirname.*?/(\w+\.py)\")", re.MULTILINE)


def commands(root: Path) -> str:
    """Return all commands of the folder `scripts` and the others of a checkout, each with its help."""
    words = {f"./scripts/{path.name}": _words(path) for path in commands_of(root)} | _OTHERS
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        helps = list(pool.map(partial(help_of, root), words.values()))
    parts = [f"## `{name}`\n\n```text\n{text}```\n" for name, text in zip(words, helps, strict=True)]
    return "\n".join(parts)


def commands_of(root: Path) -> list[Path]:
    """Return the commands of a checkout: the executable files of the folder `scripts`."""
    files = sorted((root / "scripts").iterdir())
    return [path for path in files if path.is_file() and os.access(path, os.X_OK)]


def help_of(root: Path, words: Sequence[str]) -> str:
    """Return what a command of these words prints for --help."""
    done = subprocess.run(
        [*words, "--help"],
        cwd=root,
        env={**os.environ, "COLUMNS": "100", "PYTHONPATH": python_path(root)},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    return done.stdout


def python_path(root: Path) -> str:
    """Return $PYTHONPATH with the packages of a checkout before what it has."""
    folders = [str(manifest.parent) for manifest in sorted(root.glob("src/*/package.xml"))]
    return os.pathsep.join([*folders, os.environ.get("PYTHONPATH", "")])


def _words(path: Path) -> Sequence[str]:
    """Return the words that run a command: of one that ends in Python, without the set-up before it."""
    found = _RUNS_PYTHON.search(path.read_text(encoding="utf-8"))
    if found is None:
        return [str(path)]
    return [sys.executable, *([str(path.parent / found[2])] if found[2] else found[1].split())]
