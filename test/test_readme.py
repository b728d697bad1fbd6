"""The examples in the README work as printed."""

import re
import sys
import types
from pathlib import Path

import pytest

import auv_flocking.separation
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.scenario.loading import list_scenarios, load_scenario

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def block(language):
    (text,) = re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)
    return text


def test_the_law_of_the_readme_flies_as_one_new_file(tmp_path, monkeypatch):
    (tmp_path / "gentle.py").write_text(block("python"), encoding="utf-8")
    folder = auv_flocking.separation
    monkeypatch.setattr(folder, "__path__", [*folder.__path__, str(tmp_path)])
    monkeypatch.delitem(sys.modules, "auv_flocking.separation.gentle", raising=False)
    usual = run_in_process(load_scenario("flock_acoustic", duration_s=10.0))
    overrides = ["agent.separation.kind=gentle", "agent.separation.params.strength_mps=0.4"]
    gentle = run_in_process(load_scenario("flock_acoustic", duration_s=10.0, overrides=overrides))
    assert isinstance(sys.modules.pop("auv_flocking.separation.gentle"), types.ModuleType)
    assert (usual.position_ned_m[-1] != gentle.position_ned_m[-1]).any()


def test_every_scenario_has_its_line_in_the_documentation():
    page = (ROOT / "docs/reference/scenarios.md").read_text(encoding="utf-8")
    assert [name for name, _ in list_scenarios() if f"`{name}`" not in page] == []


@pytest.mark.parametrize("page", ["CHANGELOG.md", "CONTRIBUTING.md", "README.md", "SECURITY.md"])
def test_links_lead_somewhere(page):
    targets = re.findall(r"\]\((?!http)([^)#]+)\)", (ROOT / page).read_text(encoding="utf-8"))
    assert [target for target in targets if not (ROOT / target).exists()] == []


@pytest.mark.parametrize("option", sorted(set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", README))))
def test_options_named_in_the_readme_exist(option):
    sources = [*(ROOT / "scripts").iterdir(), *ROOT.glob("src/*/auv_*/**/*.py")]
    ours = any(
        re.search(rf'"{option}"|{option}\)', path.read_text(encoding="utf-8"))
        for path in sources
        if path.is_file()
    )
    assert ours or option in {"--help", "--ros-args", "--params-file"}
