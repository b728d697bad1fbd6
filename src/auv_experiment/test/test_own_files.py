"""Own metrics and figures: added by one file each; a file that fails costs only what it would have added."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from own_folder import OwnFolder

from auv_core.params import ConfigError
from auv_experiment.figures.by_law import run_drawers
from auv_experiment.figures.files import save_figures
from auv_experiment.inprocess.evaluated_run import run_evaluated
from auv_experiment.metrics.own import failure_warning, own_files_of_metrics, own_metrics
from auv_experiment.metrics.wording import meaning_of, metrics_table
from auv_experiment.recording import Recording
from auv_experiment.results import write_results
from auv_experiment.run_key import source_version
from auv_experiment.scenario.loading import load_scenario
from auv_experiment.sweeps import table as sweep_table
from auv_experiment.sweeps.plan import plan_runs
from auv_experiment.sweeps.study import study_from_plain

HEAD = "from auv_experiment.metrics import Meaning\n"
DEPTH = (
    HEAD
    + """
MEANINGS = {
    "depth_max_m": Meaning("m", "largest depth of a hull centre", 1),
    "is_deep": Meaning("", "some vehicle was below 5 m"),
}

def compute(recording, scenario):
    deepest = recording.position_ned_m[..., 2].max()
    return {"depth_max_m": deepest, "is_deep": deepest > 5.0}
"""
)
DRAW = """
from auv_experiment.figures import Drawing
from auv_experiment.figures.plotting import new_canvas

def draw(recording, scenario):
    canvas = new_canvas()
    canvas.subplots().plot(recording.t_s, recording.position_ned_m[..., 2])
    return Drawing(canvas, "Own depths", "What to see.")
"""
SCENARIO = load_scenario("ch5_four_leaders", duration_s=1.0)


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[OwnFolder]:
    folder = OwnFolder(tmp_path / "own", monkeypatch)
    yield folder
    folder.forget()


def at_rest(depth_m: float = 7.0) -> Recording:
    recording = Recording.empty(["auv_1", "auv_2", "auv_3", "auv_4"], np.arange(11) * 0.1)
    recording.position_ned_m[:] = [(0.0, 0.0, depth_m), (2.0, 0.0, 3.0), (0.0, 2.0, 3.0), (2.0, 2.0, 3.0)]
    return recording


def test_a_file_adds_metrics_to_results_report_and_terminal(own: OwnFolder, tmp_path: Path) -> None:
    own.write("metrics", "own_depth", DEPTH)
    lines: list[str] = []
    results = tmp_path / "results"
    results.mkdir()
    write_results(
        results, SCENARIO, at_rest(), mode="inprocess", real_time_factor=1.0, formats=(), tell=lines.append
    )
    metrics = json.loads((results / "metrics.json").read_text())
    assert (metrics["depth_max_m"], metrics["is_deep"], metrics["own_metrics_failed"]) == (7.0, True, None)
    assert "largest depth of a hull centre" in (results / "report.html").read_text()
    assert "7.0 m  largest depth of a hull centre" in metrics_table(metrics)
    assert lines == []


def test_a_sweep_knows_own_metrics(own: OwnFolder) -> None:
    own.write("metrics", "own_depth", DEPTH)
    plain = {"schema": 1, "name": "own", "title": "Own", "scenario": "ch5_four_leaders", "seeds": [1]}
    assert len(plan_runs(study_from_plain({**plain, "metrics": ["depth_max_m", "is_deep"]}))) == 1
    with pytest.raises(ConfigError, match=r"^study\.metrics: 'depth_min_m' is not allowed; allowed: "):
        plan_runs(study_from_plain({**plain, "metrics": ["depth_min_m"]}))


@pytest.mark.parametrize(
    ("body", "line"),
    [
        (
            "    recording.position_ned_m -= 1.0",
            "metrics/own_bad.py, line 5: ValueError: output array is read-only",
        ),
        ("    return 1 / 0", "metrics/own_bad.py, line 5: ZeroDivisionError: division by zero"),
        ("    return 3", "metrics/own_bad.py: TypeError: compute returned 3; allowed: values by key"),
        (
            "    return {'b_m': 1.0}",
            "metrics/own_bad.py: TypeError: compute returned the key 'b_m'; allowed: bad_m",
        ),
        (
            "    return {'bad_m': {1: 2}}",
            "metrics/own_bad.py: TypeError: bad_m: {1: 2} is not allowed; allowed: a value or a list",
        ),
    ],
)
def test_a_file_that_fails_is_named_and_the_rest_stays(own: OwnFolder, body: str, line: str) -> None:
    bad = f'{HEAD}MEANINGS = {{"bad_m": Meaning("m", "bad")}}\n\ndef compute(recording, scenario):\n{body}\n'
    own.write("metrics", "own_bad", bad)
    own.write("metrics", "own_depth", DEPTH)
    metrics = own_metrics(at_rest(), SCENARIO)
    assert metrics == {"bad_m": None, "depth_max_m": 7.0, "is_deep": True, "own_metrics_failed": line}
    assert failure_warning(metrics).startswith(line)


def test_values_that_are_not_finite_or_left_out_are_none(own: OwnFolder) -> None:
    body = "    return {'one_m': float('nan'), 'three': [1, float('inf')]}"
    keys = ", ".join(f"'{key}': Meaning('', 'words')" for key in ("one_m", "two_m", "three"))
    text = f"{HEAD}MEANINGS = {{{keys}}}\ndef compute(recording, scenario):\n{body}\n"
    own.write("metrics", "own_gaps", text)
    expected = {"one_m": None, "two_m": None, "three": [1, None], "own_metrics_failed": None}
    assert own_metrics(at_rest(), SCENARIO) == expected


@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        ("own_a", "1 +", "metrics/own_a.py: cannot be imported (SyntaxError: "),
        ("own_b", "MEANINGS = {}", "metrics/own_b.py: compute is missing; allowed: "),
        ("own_c", "def compute(r, s): ...", "metrics/own_c.py: MEANINGS is missing; allowed: a Meaning"),
        (
            "own_d",
            DEPTH.replace("depth_max_m", "collision"),
            "metrics/own_d.py: MEANINGS: 'collision' is taken by Shoal; allowed: another key",
        ),
        (
            "own_e",
            DEPTH.replace("depth_max_m", "Depth"),
            "metrics/own_e.py: MEANINGS: 'Depth' is not allowed",
        ),
        (
            "own_f",
            'MEANINGS = {"a_m": "words"}\ndef compute(r, s): ...',
            "metrics/own_f.py: MEANINGS: a_m: 'words' is not allowed; allowed: a Meaning",
        ),
        ("safety", DEPTH, "metrics/safety.py: the name is taken by "),
        ("Own", DEPTH, "metrics/Own.py: 'Own' is not allowed; allowed: lower-case letters"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_before_a_flight(
    own: OwnFolder, name: str, text: str, complaint: str
) -> None:
    own.write("metrics", name, text)
    with pytest.raises(ConfigError) as caught:
        run_evaluated(SCENARIO)
    assert str(caught.value).startswith(complaint)
    assert "\n" not in str(caught.value)


def test_two_files_may_not_describe_one_metric(own: OwnFolder) -> None:
    own.write("metrics", "own_depth", DEPTH)
    own.write("metrics", "own_other", DEPTH)
    with pytest.raises(
        ConfigError, match=r"own_other\.py: .*'depth_max_m' is taken by metrics/own_depth\.py"
    ):
        own_files_of_metrics()


def test_an_own_figure_is_drawn_after_the_others(own: OwnFolder, tmp_path: Path) -> None:
    own.write("figures", "own_depths", DRAW)
    drawers = run_drawers(at_rest(), SCENARIO)
    assert list(drawers)[-1] == "own_depths"
    saved = save_figures({"own_depths": drawers["own_depths"]}, SCENARIO, tmp_path, ("png", "svg"))
    assert [figure.title for figure in saved.figures] == ["Own depths"]
    assert {path.name for path in tmp_path.glob("own_depths.*")} == {"own_depths.png", "own_depths.svg"}


def test_a_figure_that_fails_is_named_in_the_report_and_the_rest_stays(
    own: OwnFolder, tmp_path: Path
) -> None:
    own.write("figures", "own_broken", "def draw(recording, scenario):\n    return recording.no_such_array\n")
    own.write("figures", "own_number", "def draw(recording, scenario):\n    return 3\n")
    own.write("figures", "own_nothing", "def draw(recording, scenario):\n    return None\n")
    lines: list[str] = []
    kind = {"mode": "inprocess", "real_time_factor": 1.0}
    write_results(tmp_path, SCENARIO, at_rest(), **kind, tell=lines.append)  # type: ignore[arg-type]
    assert [line.partition(": ")[0] for line in lines] == [
        "figures/own_broken.py, line 2",
        "figures/own_number.py",
    ]
    page = (tmp_path / "report.html").read_text()
    assert page.count("A figure is left out: figures/own_") == 2
    assert (tmp_path / "figures" / "plan.png").is_file()


@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        ("own_a", "def make(r, s): ...", r"figures/own_a\.py: draw is missing; allowed: "),
        (
            "pair_distances",
            DRAW,
            r"figures/pair_distances\.py: the name is that of another figure; allowed: ",
        ),
        ("plotting", DRAW, r"figures/plotting\.py: the name is taken by "),
    ],
)
def test_a_figure_that_cannot_be_used_is_refused(
    own: OwnFolder, name: str, text: str, complaint: str
) -> None:
    own.write("figures", name, text)
    with pytest.raises(ConfigError, match=complaint):
        run_drawers(at_rest(), SCENARIO)


def test_kept_runs_are_flown_again_after_a_change_of_metrics_and_not_of_figures(own: OwnFolder) -> None:
    def version() -> Any:
        source_version.cache_clear()
        return source_version()

    nothing = version()
    own.write("figures", "own_depths", DRAW)
    assert version() == nothing
    own.write("metrics", "own_depth", DEPTH)
    assert version() != nothing
    source_version.cache_clear()


def test_without_the_folder_nothing_is_left(own: OwnFolder, monkeypatch: pytest.MonkeyPatch) -> None:
    own.write("metrics", "own_depth", DEPTH)
    assert meaning_of("depth_max_m").unit == "m"
    monkeypatch.setenv("SHOAL_PLUGINS", "")
    assert own_metrics(at_rest(), SCENARIO) == {}
    assert meaning_of("depth_max_m").words == "depth max m"


@pytest.mark.parametrize("key", sorted(sweep_table._TYPES))
def test_no_own_metric_is_named_as_another_column_of_a_sweep(own: OwnFolder, key: str) -> None:
    own.write("metrics", "own_column", DEPTH.replace("depth_max_m", key))
    with pytest.raises(ConfigError, match=f"'{key}' is taken by Shoal"):
        own_files_of_metrics()
