"""
The report of a run: one HTML file that needs nothing else.

Figures are embedded, styles are inline, there is no script and no address to fetch from, so that the file
can be mailed, printed or read on a phone at sea. Everything that comes from a scenario or from data is
escaped.
"""

from __future__ import annotations

import base64
import html
import importlib.metadata
import json
import math
import os
import platform
import shlex
from collections.abc import Sequence
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

import numpy as np

from auv_core.machine.whole_files import write_text
from auv_experiment.metrics.descriptions import shown_metrics, value_text
from auv_experiment.metrics.surface import surface_warning

if TYPE_CHECKING:
    from auv_experiment.report.flock import Figure
    from auv_experiment.scenario.schema import Scenario

REPORT_FILE = "report.html"

_CLOSE_LIMIT_M = 4.0
_CONSISTENT_SHARE = (0.90, 0.985)
_SHOWN_PACKAGES = ("numpy", "scipy", "numba", "matplotlib", "mcap", "rosbags", "ros-jazzy-rclpy")


# Continuous-time solution of the same equations (RK4, 0.01 s, 650 s) and, where printed, the thesis's value.
_REFERENCES: dict[str, dict[str, tuple[float, str]]] = {
    "ch5_four_leaders": {
        "pair_distance_settled_min_m": (1.5950, "1.575"),
        "pair_distance_settled_max_m": (1.5950, "1.616"),
        "pair_distance_min_m": (1.451, ""),
        "approach_time_2pct_s": (3.90, "2.9 (other starts)"),
        "centroid_path_rms_m": (0.1000, ""),
        "consensus_error_max_m": (0.2895, ""),
    },
    "ch5_one_leader": {
        "pair_distance_settled_min_m": (1.5908, "1.584"),
        "pair_distance_settled_max_m": (1.6078, "1.611"),
        "pair_distance_min_m": (1.449, ""),
        "approach_time_2pct_s": (4.00, "2.4 (other starts)"),
        "centroid_path_rms_m": (0.1749, ""),
        "consensus_error_max_m": (0.2680, ""),
    },
    "ch5_one_leader_blind": {
        "pair_distance_settled_min_m": (1.7171, ""),
        "pair_distance_settled_max_m": (1.8844, ""),
        "pair_distance_min_m": (1.605, ""),
        "approach_time_2pct_s": (56.4, ""),
        "centroid_path_rms_m": (1.8759, ""),
        "consensus_error_max_m": (0.2697, ""),
    },
    "ch5_obstacles": {
        "obstacle_clearance_min_m": (1.298, ""),
        "centroid_path_rms_m": (0.243, ""),
    },
}

_PAGE = Template("""\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy"
  content="default-src 'none'; img-src data:; style-src 'unsafe-inline'">
<title>$title</title>
<style>
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 58rem; padding: 1.2rem 1rem 3rem; color: #1a1a1a; background: #fff;
  font: 1rem/1.5 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; overflow-wrap: break-word; }
h1 { font-size: 1.5rem; line-height: 1.25; margin: 0 0 .3rem; }
h2 { font-size: 1.15rem; margin: 2.2rem 0 .6rem; border-bottom: 1px solid #bbb; padding-bottom: .2rem; }
.facts { color: #555; margin: 0 0 1rem; }
.verdicts { list-style: none; margin: 1rem 0; padding: 0; }
.verdicts li { border-left: .35rem solid #999; padding: .15rem 0 .15rem .7rem; margin: .45rem 0; }
.verdicts li.good { border-color: #1d7a46; }
.verdicts li.bad { border-color: #b3261e; background: #fdf0ef; }
.verdicts b { display: inline-block; min-width: 2.6rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .92rem; }
th, td { text-align: left; vertical-align: top; padding: .3rem .6rem .3rem 0; border-bottom: 1px solid #ddd; }
td.value, th.value { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
td.none { color: #777; }
code, pre { font: .85rem/1.45 ui-monospace, "DejaVu Sans Mono", Consolas, monospace; }
td code { color: #555; }
pre { background: #f4f4f4; padding: .7rem .8rem; overflow-x: auto; border-radius: .3rem; }
figure { margin: 1.6rem 0; break-inside: avoid; }
img { display: block; max-width: 100%; height: auto; margin: 0 auto; }
figcaption { font-size: .92rem; margin-top: .4rem; }
details { margin: 1rem 0; }
summary { cursor: pointer; font-weight: 600; }
@media (max-width: 40rem) { .key { display: none; } body { padding: .8rem .7rem 2rem; } }
@media print { body { max-width: none; font-size: 10pt; } tr { break-inside: avoid; }
  pre { white-space: pre-wrap; } }
</style>
</head>
<body>
<h1>$title</h1>
<p class="facts">$facts</p>
<p>$flown</p>
<h2>What came of it</h2>
<ul class="verdicts">
$verdicts
</ul>
<h2>Numbers</h2>
<div class="scroll">
$numbers
</div>
$figures
<h2>Do it again</h2>
$again
<h2>Made with</h2>
<div class="scroll">
$versions
</div>
<details><summary>The scenario, resolved</summary>
<pre>$scenario</pre>
</details>
</body>
</html>
""")


def write_report(
    results_dir: Path, scenario: Scenario, metrics: dict[str, Any], figures: Sequence[Figure]
) -> Path:
    """
    Write `report.html` into a results folder.

    Parameters
    ----------
    results_dir : Path
        The run's folder. `scenario.yaml` and `provenance.json` are read from it where they exist.
    scenario : Scenario
        What was asked for.
    metrics : dict
        What `compute_metrics` returned.
    figures : sequence of Figure
        What `run_figures` returned; their files are embedded.

    Returns
    -------
    path : Path
        The report.

    """
    provenance = _provenance(results_dir)
    page = _PAGE.substitute(
        title=html.escape(scenario.title),
        facts=html.escape(f"{scenario.name}, seed {scenario.seed}, {metrics.get('mode')}"),
        flown=html.escape(_flown(scenario, metrics) + _strangers(provenance)),
        verdicts="\n".join(_verdicts(scenario, metrics)),
        numbers=_numbers_table(scenario, metrics),
        figures=_figures_section(figures),
        again=_again(results_dir, scenario, metrics, provenance),
        versions=_versions_table(provenance),
        scenario=html.escape(_scenario_text(results_dir, scenario)),
    )
    path = results_dir / REPORT_FILE
    write_text(path, page)
    return path


def _flown(scenario: Scenario, metrics: dict[str, Any]) -> str:
    """Say in a few sentences what was flown."""
    n = len(scenario.vehicles)
    who = "all leaders" if len(scenario.leaders) == n else f"leaders: {', '.join(scenario.leaders) or 'none'}"
    if scenario.agent.flocking is None:
        who = f"each by itself with the law {scenario.agent.controller.kind}"
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


def _strangers(provenance: dict[str, Any]) -> str:
    """Say who else published on topics of the run."""
    strangers = provenance.get("strangers") or []
    return f" Strangers on its topics, not recorded: {'; '.join(map(str, strangers))}." if strangers else ""


def _known(scenario: Scenario) -> str:
    """Say how vehicles knew where they were and saw each other, where that is not exactly and not at all."""
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
    count = len(scenario.environment.obstacles)
    current_mps = math.hypot(*scenario.environment.current_ned_mps)
    parts = [f"{count} obstacle{'s' if count != 1 else ''}"] if count else []
    parts += [f"a current of {current_mps:.2f} m/s"] if current_mps > 0.0 else []
    return f", with {' and '.join(parts)}" if parts else ""


def _verdicts(scenario: Scenario, metrics: dict[str, Any]) -> list[str]:
    """Answer the plain questions, each with its number."""
    get = metrics.get
    contact_m = 2.0 * scenario.hull_radius_m
    answers = []
    nearest_m = get("pair_distance_min_m")
    if nearest_m is not None:
        detail = f"Smallest distance of two hull centres {nearest_m:.2f} m; hulls touch at {contact_m:g} m."
        if get("collision"):
            detail += f" First contact at {get('collision_at_s'):.1f} s."
        answers.append(_answer("Did hulls touch?", bool(get("collision")), detail, good=False))
        answers.append(_formed_answer(metrics))
    if surface_warning(metrics):
        answers.append(_answer("Did hulls leave the water?", True, surface_warning(metrics), good=False))
    farthest_m = get("pair_distance_formed_max_m")
    if farthest_m is not None:
        detail = f"Once formed between {get('pair_distance_formed_min_m'):.2f} and {farthest_m:.2f} m apart."
        answers.append(_answer("Did the flock stay together?", farthest_m <= _CLOSE_LIMIT_M, detail))
    clearance_m = get("obstacle_clearance_min_m")
    if clearance_m is not None:
        detail = (
            f"Smallest distance to an obstacle {clearance_m:.2f} m, hull radius {scenario.hull_radius_m:g} m."
        )
        answers.append(
            _answer("Did it keep clear of obstacles?", clearance_m > scenario.hull_radius_m, detail)
        )
    lost = get("lost_vehicles") or []
    answers.append(
        _answer("Did every vehicle reach the end?", not lost, f"Lost: {', '.join(lost)}." if lost else "")
    )
    share = get("neighbour_within_2sigma_ratio")
    if share is not None:
        answers.append(_consistency_answer(share))
    return answers


def _answer(question: str, holds: bool, detail: str, *, good: bool = True) -> str:
    kind = "good" if holds is good else "bad"
    word = "Yes." if holds else "No."
    return f'<li class="{kind}">{html.escape(question)} <b>{word}</b> {html.escape(detail)}</li>'


def _formed_answer(metrics: dict[str, Any]) -> str:
    formed_at_s = metrics.get("formed_at_s")
    detail = "" if formed_at_s is None else f"Every pair had been under 4 m for 10 s at {formed_at_s:.1f} s."
    return _answer("Did the flock form?", formed_at_s is not None, detail)


def _consistency_answer(share: float) -> str:
    low, high = _CONSISTENT_SHARE
    judgement = "cautious: errors are smaller than they say" if share > high else "consistent"
    if share < low:
        judgement = "overconfident: errors are larger than they say"
    detail = f"{share:.3f} of the errors lie inside 2 sigma, 0.954 expected; the filters are {judgement}."
    return _answer("Do the filters cover their errors?", share >= low, detail)


def _numbers_table(scenario: Scenario, metrics: dict[str, Any]) -> str:
    references = _REFERENCES.get(scenario.name, {})
    head = "<tr><th>meaning</th><th class='value'>value</th><th>unit</th>"
    head += "<th class='value'>reference</th><th class='value'>thesis</th>" if references else ""
    rows = [head + "<th class='key'>key</th></tr>"]
    for key, meaning in shown_metrics(metrics):
        text = value_text(metrics[key], meaning.digits)
        cells = [f"<td>{html.escape(meaning.words)}</td>"]
        cells.append(
            f"<td class='value{'' if metrics[key] is not None else ' none'}'>{html.escape(text)}</td>"
        )
        cells.append(f"<td>{html.escape(meaning.unit)}</td>")
        if references:
            reference, thesis = references.get(key, (None, ""))
            shown = "" if reference is None else f"{reference:g}"
            cells.append(f"<td class='value'>{shown}</td><td class='value'>{html.escape(thesis)}</td>")
        cells.append(f"<td class='key'><code>{html.escape(key)}</code></td>")
        rows.append(f"<tr>{''.join(cells)}</tr>")
    note = (
        "<p>Reference: the same equations in continuous time (Runge-Kutta, 0.01 s, 650 s). "
        "Thesis: the number printed there.</p>"
        if references
        else ""
    )
    return "<table>\n" + "\n".join(rows) + "\n</table>\n" + note


def _figures_section(figures: Sequence[Figure]) -> str:
    parts = ["<h2>Figures</h2>"] if figures else []
    for number, figure in enumerate(figures, start=1):
        image = base64.b64encode(figure.path.read_bytes()).decode("ascii")
        title, caption = html.escape(figure.title), html.escape(figure.caption)
        parts.append(
            f'<figure>\n<img alt="{title}" src="data:image/png;base64,{image}">\n'
            f"<figcaption><strong>Figure {number}. {title}.</strong> {caption}</figcaption>\n</figure>"
        )
    return "\n".join(parts)


def _again(results_dir: Path, scenario: Scenario, metrics: dict[str, Any], provenance: dict[str, Any]) -> str:
    """Give the commands that repeat and replay the run."""
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
    from auv_experiment.scenario.schema import scenario_to_yaml

    return scenario_to_yaml(scenario)
