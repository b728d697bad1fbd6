"""The tutorials work as they are printed: each file is written, each command and program is run, in order."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from from_code.commands import python_path

ROOT = Path(__file__).parents[1]
TUTORIALS = [
    *sorted((ROOT / "docs/tutorials").glob("[!i]*.md")),
    ROOT / "docs/how_to/own_metrics.md",
]
BLOCK = re.compile(r"^```(\w+)(?: title=\"([^\"]+)\")?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
RUN = {"bash": "{text}", "python": "python - <<'END'\n{text}END\n"}


def as_script(page):
    """Return a script of bash that does what a page tells its reader to do."""
    steps = []
    for language, file, text in BLOCK.findall(page):
        steps.append(f"cat > {file} <<'END'\n{text}END\n" if file else RUN[language].format(text=text))
    return "set -euo pipefail\n" + "\n".join(steps)


@pytest.fixture
def environment(tmp_path):
    """Return the environment of a reader: the packages can be imported, and `shoal` is a command."""
    command = tmp_path / "bin" / "shoal"
    command.parent.mkdir()
    command.write_text('#!/bin/sh\nexec python -P -m shoal.commands "$@"\n', encoding="utf-8")
    command.chmod(0o755)
    return {
        **os.environ,
        "PATH": os.pathsep.join([str(command.parent), str(Path(sys.executable).parent), os.environ["PATH"]]),
        "PYTHONPATH": python_path(ROOT),
        "MPLBACKEND": "agg",
    }


@pytest.mark.parametrize("path", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial_works_as_it_is_printed(path, tmp_path, environment):
    place = tmp_path / "reader"
    place.mkdir()
    done = subprocess.run(
        ["bash", "-c", as_script(path.read_text(encoding="utf-8"))],
        cwd=place,
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Traceback" not in done.stderr


def test_the_tutorials_are_found():
    assert {path.stem for path in TUTORIALS} == {"first_scenario", "own_law", "own_vehicle", "own_metrics"}


def test_a_page_becomes_a_script():
    page = '```yaml title="a/b.yaml"\nx: 1\n```\n\n```bash\nls\n```\n\n```python\nprint(1)\n```\n'
    assert as_script(page) == (
        "set -euo pipefail\ncat > a/b.yaml <<'END'\nx: 1\nEND\n\nls\n\npython - <<'END'\nprint(1)\nEND\n"
    )
