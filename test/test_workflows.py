"""The workflows and forms of the project's page, and CITATION.cff, match their published schemas."""

import importlib.util
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
SCHEMAS = {
    "github-workflows": WORKFLOWS,
    "github-issue-forms": [
        ROOT / ".github" / "ISSUE_TEMPLATE" / f"{name}.yml" for name in ("bug", "feature")
    ],
    "github-issue-config": [ROOT / ".github" / "ISSUE_TEMPLATE" / "config.yml"],
    "citation-file-format": [ROOT / "CITATION.cff"],
}
REQUIRED = {"ci.yml", "apt-jazzy.yml", "wheels.yml"}


def steps():
    """Return every step of every workflow, with the workflow's name."""
    for path in WORKFLOWS:
        for job in yaml.safe_load(path.read_text(encoding="utf-8"))["jobs"].values():
            yield from ((path.name, step) for step in job["steps"])


def commands():
    return [(name, step["run"]) for name, step in steps() if "run" in step]


def validated(schema, paths):
    if importlib.util.find_spec("check_jsonschema") is None:
        pytest.skip("check-jsonschema is not installed: ./scripts/setup brings it")
    return subprocess.run(
        [sys.executable, "-m", "check_jsonschema", "--builtin-schema", f"vendor.{schema}", *map(str, paths)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def test_the_workflows_are_found():
    assert {path.name for path in WORKFLOWS} >= REQUIRED


@pytest.mark.parametrize("schema", SCHEMAS)
def test_files_follow_their_schema(schema):
    done = validated(schema, SCHEMAS[schema])
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_workflow_with_a_wrong_key_is_found(tmp_path):
    broken = tmp_path / "ci.yml"
    text = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    broken.write_text(text.replace("runs-on:", "run-on:"), encoding="utf-8")
    assert validated("github-workflows", [broken]).returncode == 1


def test_actionlint_has_nothing_to_say():
    if shutil.which("actionlint") is None:
        pytest.skip("actionlint is not on the PATH (ci.yml installs it)")
    done = subprocess.run(
        ["actionlint", *map(str, WORKFLOWS)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(("workflow", "script"), commands())
def test_commands_are_bash(workflow, script):
    plain = re.sub(r"\$\{\{.*?\}\}", "x", script)
    done = subprocess.run(
        ["bash", "-n"], input=plain, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, f"{workflow}: {done.stderr}"


@pytest.mark.parametrize(("workflow", "script"), commands())
def test_files_named_in_commands_exist(workflow, script):
    for name in re.findall(r"(?<![\w/])(?:\./scripts|scripts|\.ci|test)/[\w./-]+", script):
        assert (ROOT / name).exists(), f"{workflow}: {name}"


def test_actions_are_pinned_to_a_version():
    used = [step["uses"] for _, step in steps() if "uses" in step]
    assert used
    assert [name for name in used if not re.fullmatch(r"[\w-]+/[\w-]+@v\d+(\.\d+)*", name)] == []


def test_citation_has_what_a_reference_needs():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert {"title", "authors", "version", "license", "message"} <= set(citation)
    assert citation["license"] == "Apache-2.0"
