"""
The report of a run: one self-contained HTML file.

Figures are embedded and styles are inline. There are no scripts, and nothing is fetched from the network, so
the file can be mailed, printed or read on a phone at sea. All text from a scenario or from data is escaped.
"""

from __future__ import annotations

import html
import importlib.metadata
import json
import math
import os
import platform
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from auv_core.machine.whole_files import write_text
from auv_experiment.report.html import embedded_png, head
from auv_experiment.report.numbers_table import numbers_table
from auv_experiment.report.template import PAGE
from auv_experiment.report.verdicts import verdicts
from auv_experiment.scenario.teams import team_scenarios
from auv_sim.vehicle import STEADY

if TYPE_CHECKING:
    from auv_experiment.figures import SavedFigures
    from auv_experiment.scenario.schema import Scenario

REPORT_FILE = "report.html"

_SHOWN_PACKAGES = ("numpy", "scipy", "numba", "matplotlib", "mcap", "rosbags", "ros-jazzy-rclpy")


def write_report(results_dir: Path, scenario: Scenario, metrics: dict[str, Any], saved: SavedFigures) -> Path:
    """
    Write `report.html` into a results folder.

    Parameters
    ----------
    results_dir : Path
        The run's folder. `scenario.yaml` and `provenance.json` are read from it if they exist.
    scenario : Scenario
        The scenario of the run.
    metrics : dict
        Result of `compute_metrics`.
    saved : SavedFigures
        Result of `save_figures`; the files are embedded.

    Returns
    -------
    path : Path
        The report.

    """
    provenance = _provenance(results_dir)
    page = PAGE.substitute(
        head=head(scenario.title),
        title=html.escape(scenario.title),
        facts=html.escape(f"{scenario.name}, seed {scenario.seed}, {metrics.get('mode')}"),
        flown=html.escape(_flown(scenario, metrics) + _strangers(provenance)),
        verdicts="\n".join(verdicts(scenario, metrics)),
        numbers=numbers_table(scenario, metrics),
        figures=_figures_section(saved),
        again=_again(results_dir, scenario, metrics, provenance),
        versions=_versions_table(provenance),
        scenario=html.escape(_scenario_text(results_dir, scenario)),
    )
    path = results_dir / REPORT_FILE
    write_text(path, page)
    return path


def _flown(scenario: Scenario, metrics: dict[str, Any]) -> str:
    """Return a few sentences about the run."""
    n, parts = len(scenario.vehicles), team_scenarios(scenario)
    who = "; ".join(_who(team, names=len(parts) > 1) for team in parts)
    path = "" if scenario.reference is None else f", their path a {scenario.reference.kind}"
    flown_s = metrics.get("duration_s", scenario.duration_s)
    first = f"{n} vehicle{'s' if n != 1 else ''} ({who}) flew {flown_s:g} s{path}{_water(scenario)}."
    if scenario.sampling == "continuous":
        laws = "the laws were evaluated in every integration stage"
    else:
        laws = f"the laws ran every {scenario.period_s:g} s"
    medium = scenario.acoustics
    return (
        f"{first} The water was stepped every {scenario.dt_s:g} s and {laws}; the vehicles talked over the "
        f"{medium.preset or 'given'} medium (access {medium.mac.kind}, losses {medium.outage.kind})."
        f"{_known(scenario)}"
    )


def _task(team: Scenario) -> str:
    """Return what vehicles of a team that is no flock do."""
    agent = team.agent
    if agent.fleet is not None:
        return f"a fleet of the kind {agent.fleet.kind}"
    course = "" if agent.course is None else f" on a course of the kind {agent.course.kind}"
    return f"each by itself{course} with the law {agent.controller.kind}"


def _who(team: Scenario, *, names: bool) -> str:
    """Return what the vehicles of a team are, with their names if there are other teams."""
    n = len(team.vehicles)
    who = "all leaders" if len(team.leaders) == n else f"leaders: {', '.join(team.leaders) or 'none'}"
    if team.agent.flocking is None:
        who = _task(team)
    return f"{', '.join(vehicle.id for vehicle in team.vehicles)}: {who}" if names else who


def _strangers(provenance: dict[str, Any]) -> str:
    """Return a sentence about foreign publishers on topics of the run."""
    strangers = provenance.get("strangers") or []
    return (
        f" Foreign publishers on its topics, not recorded: {'; '.join(map(str, strangers))}."
        if strangers
        else ""
    )


def _known(scenario: Scenario) -> str:
    """Return a sentence about navigation and sonar, unless navigation is exact and there is no sonar."""
    navigation, sonar = scenario.environment.navigation, scenario.acoustics.sonar
    parts = []
    if navigation.kind != "exact":
        fix = getattr(navigation.params, "fix", "none")
        fixes = "" if fix == "none" else f" with {fix} fixes every {navigation.params.fix_period_s:g} s"
        parts.append(f"knew their own position by {navigation.kind.replace('_', ' ')}{fixes}")
    if sonar.kind != "none":
        reach_m = getattr(sonar.params, "max_range_m", None)
        reach = "" if reach_m is None else f" up to {reach_m:g} m"
        parts.append(f"saw each other by sonar{reach}")
    return f" They {' and '.join(parts)}." if parts else ""


def _water(scenario: Scenario) -> str:
    obstacles = scenario.environment.obstacles
    count, unknown = len(obstacles), sum(not obstacle.known for obstacle in obstacles)
    current_mps = math.hypot(*scenario.environment.current_ned_mps)
    told = f" ({unknown} of them not known before)" if unknown else ""
    parts = [f"{count} obstacle{'s' if count != 1 else ''}{told}"] if count else []
    is_steady = scenario.environment.current.kind == STEADY.kind
    varying = "" if is_steady else " that varies"
    parts += [f"a current of {current_mps:.2f} m/s{varying}"] if current_mps > 0.0 or not is_steady else []
    return f", with {' and '.join(parts)}" if parts else ""


def _figures_section(saved: SavedFigures) -> str:
    parts = ["<h2>Figures</h2>"] if saved.figures or saved.failures else []
    parts += [f"<p class='failure'>A figure is left out: {html.escape(line)}</p>" for line in saved.failures]
    for number, figure in enumerate(saved.figures, start=1):
        title, caption = html.escape(figure.title), html.escape(figure.caption)
        parts.append(
            f"<figure>\n{embedded_png(figure.path.read_bytes(), figure.title)}\n"
            f"<figcaption><strong>Figure {number}. {title}.</strong> {caption}</figcaption>\n</figure>"
        )
    return "\n".join(parts)


def _again(results_dir: Path, scenario: Scenario, metrics: dict[str, Any], provenance: dict[str, Any]) -> str:
    """Return the commands that repeat and replay the run."""
    command = [
        "./scripts/run",
        scenario.name,
        "--seed",
        str(scenario.seed),
        "--mode",
        str(metrics.get("mode")),
    ]
    if provenance.get("duration_was_set"):
        command += ["--duration", f"{scenario.duration_s:g}"]
    for override in provenance.get("overrides") or []:
        command += ["--set", str(override)]
    folder = f"results/{results_dir.name}"
    parts = [
        "<p>Fly the same run again:</p>",
        _pre(shlex.join(command)),
        "<p>The same, from the resolved scenario in the results folder:</p>",
        _pre(shlex.join(["./scripts/run", f"{folder}/scenario.yaml", "--mode", str(metrics.get("mode"))])),
    ]
    if (results_dir / "bag").is_dir():
        parts += [
            "<p>Replay its bag to ROS 2, and run the neighbour filters again on the recorded packets:</p>",
            _pre(
                f"{shlex.join(['./scripts/replay', f'{folder}/bag', '--clock'])}\n"
                f"{shlex.join(['./scripts/replay', f'{folder}/bag', '--re-estimate'])}"
            ),
        ]
    elif (results_dir / "recording.npz").is_file():
        parts += [
            "<p>A run in one process keeps arrays in place of a bag:</p>",
            _pre(
                "from auv_experiment.recording import Recording\n"
                f"recording = Recording.load({f'{folder}/recording.npz'!r})"
            ),
        ]
    return "\n".join(parts)


def _pre(text: str) -> str:
    return f"<pre>{html.escape(text)}</pre>"


def _versions_table(provenance: dict[str, Any]) -> str:
    packages = provenance.get("packages") or {}
    versions = {
        "Python": provenance.get("python") or platform.python_version(),
        "ROS 2": os.environ.get("ROS_DISTRO", "not sourced"),
        "numpy": np.__version__,
        "matplotlib": importlib.metadata.version("matplotlib"),
    }
    versions.update({name: packages[name] for name in _SHOWN_PACKAGES if name in packages})
    versions["system"] = provenance.get("platform") or platform.platform()
    git = provenance.get("git")
    if git:
        changed = ", with local changes" if git.get("has_local_changes") else ""
        versions["revision"] = f"{git.get('revision')}{changed}"
    if provenance.get("started_at"):
        versions["started"] = provenance["started_at"]
    rows = (f"<tr><td>{html.escape(k)}</td><td>{html.escape(str(v))}</td></tr>" for k, v in versions.items())
    return "<table>\n" + "\n".join(rows) + "\n</table>"


def _provenance(results_dir: Path) -> dict[str, Any]:
    path = results_dir / "provenance.json"
    if not path.is_file():
        return {}
    content = json.loads(path.read_text(encoding="utf-8"))
    return content if isinstance(content, dict) else {}


def _scenario_text(results_dir: Path, scenario: Scenario) -> str:
    path = results_dir / "scenario.yaml"
    if path.is_file():
        return path.read_text(encoding="utf-8")
    from auv_experiment.scenario.loading import scenario_to_yaml

    return scenario_to_yaml(scenario)
