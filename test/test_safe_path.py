"""No command runs Python code that lies in the folder from which it is called."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from auv_bringup.launching.node_start import command_line

ROOT = Path(__file__).parents[1]
STARTS_PYTHON = re.compile(r"""(?:\bpython3?|"\$(?:base_)?python")\s+(?P<options>.*)""")


def test_every_script_starts_python_with_a_safe_path():
    lines = [
        (path.name, line)
        for path in sorted((ROOT / "scripts").iterdir())
        if path.is_file() and path.suffix != ".py"
        for line in path.read_text(encoding="utf-8").splitlines()
        if not line.lstrip().startswith("#")
    ]
    starts = [(name, found["options"]) for name, line in lines if (found := STARTS_PYTHON.search(line))]
    runs = [(name, options) for name, options in starts if re.search(r"(^|\s)-m\b|\.py\b", options)]
    assert len(runs) > 8
    # pytest wants the folder of the checkout, in which `test` calls it.
    unsafe = [(name, options) for name, options in runs if not options.startswith(("-P", "-I"))]
    assert {name for name, _ in unsafe} == {"test"}


@pytest.mark.ros
@pytest.mark.parametrize("command", ["scripts/run --list", "node"])
def test_a_module_of_the_current_folder_is_not_imported(command, tmp_path):
    for name in ("yaml", "numpy", "json", "rclpy"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('code of the current folder')")
    words = command_line(()) if command == "node" else [str(ROOT / "scripts" / "run"), "--list"]
    done = subprocess.run(
        words, cwd=tmp_path, env=os.environ, capture_output=True, text=True, timeout=100, check=False
    )
    assert "code of the current folder" not in done.stdout + done.stderr
    assert done.returncode == (2 if command == "node" else 0)  # a container wants to be told its nodes
    assert words[0] == sys.executable or "flock_acoustic" in done.stdout
