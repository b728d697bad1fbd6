"""Every command has a help text, and refuses unknown arguments in one line."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from from_code.commands import commands_of, python_path

ROOT = Path(__file__).parents[1]
SCRIPTS = commands_of(ROOT)
UNKNOWN = "--no-such-option"


def of_script(path):
    """Return a command of scripts/ as a parameter; those that bring up the workspace need it built."""
    needs_workspace = "activate.bash" in path.read_text(encoding="utf-8")
    marks = [pytest.mark.ros] if needs_workspace else []
    return pytest.param([str(path)], f"./scripts/{path.name}", id=path.name, marks=marks)


COMMANDS = [
    *map(of_script, SCRIPTS),
    pytest.param([sys.executable, "-m", "benchmarks"], "python -m benchmarks", id="benchmarks"),
]


def run(command, *arguments):
    return subprocess.run(
        [*command, *arguments],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": python_path(ROOT)},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_the_commands_are_found():
    assert {"run", "setup", "test"} <= {path.name for path in SCRIPTS}


@pytest.mark.parametrize(("command", "name"), COMMANDS)
def test_help_shows_examples(command, name):
    done = run(command, "--help")
    assert (done.returncode, done.stderr) == (0, "")
    _, heading, examples = done.stdout.partition("examples:\n")
    assert heading
    assert examples.count(name) >= 2


@pytest.mark.parametrize(("command", "name"), COMMANDS)
def test_an_unknown_option_is_bad_input(command, name):
    done = run(command, UNKNOWN)
    assert (done.returncode, done.stdout) == (2, "")
    (line,) = done.stderr.splitlines()
    assert line.startswith("error: ")
    assert line.endswith(f"({name} --help says more)")


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--wiht", "bellhop"], "'--wiht' is not allowed; allowed: --check, --with bellhop, --help"),
        (["--with"], "--with '' is not allowed; allowed: bellhop"),
        (["--with", "ros"], "--with 'ros' is not allowed; allowed: bellhop"),
        (["--check", "now"], "'now' is not allowed; allowed: --check, --with bellhop, --help"),
        (
            ["--with", "bellhop", "--check"],
            "--check and --with are not allowed together; allowed: one of them",
        ),
    ],
)
def test_set_up_takes_no_argument_in_silence(arguments, complaint):
    done = run([str(ROOT / "scripts" / "setup")], *arguments)
    assert done.returncode == 2
    assert done.stderr == f"error: {complaint} (./scripts/setup --help says more)\n"


@pytest.mark.ros  # brings up the workspace
def test_the_test_command_wants_an_expression_after_its_m():
    done = run([str(ROOT / "scripts" / "test")], "-m")
    assert done.returncode == 2
    assert done.stderr.startswith("error: -m lacks its value; allowed: an expression of marks")
