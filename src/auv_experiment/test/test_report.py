"""The report: complete, self-contained, and foreign text in it is never interpreted as HTML."""

from __future__ import annotations

import base64
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from auv_core.models import hovering
from auv_experiment.figures import Figure, SavedFigures
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.recording import Recording
from auv_experiment.report.report import write_report
from auv_experiment.scenario.schema import Obstacle

HOSTILE = '<script>alert("1")</script> & <img src=x onerror=alert(1)> $title ${facts}'
ONE_PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGP4DwABAQEAsPDeJgAAAABJRU5ErkJggg=="
)
VOID = {"meta", "img", "br", "link", "input", "hr"}


class Outline(HTMLParser):
    """Collects tags and attributes, and insists that every element is closed in order."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str, str | None]] = []
        self.text = ""
        self._open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(tag, name, value) for name, value in attrs]
        if tag not in VOID:
            self._open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data

    def close(self) -> None:
        super().close()
        assert self._open == []


def make_scenario(**changes: Any) -> Any:
    kind = SimpleNamespace
    values = {
        "name": "by_hand",
        "title": "Four vehicles at rest",
        "seed": 7,
        "duration_s": 120.0,
        "dt_s": 0.02,
        "period_s": 1.0,
        "sampling": "sampled",
        "hull_radius_m": 0.3,
        "hull_radii_m": (0.3, 0.3, 0.3, 0.3),
        "handlings": 4 * (hovering(0.3),),
        "vehicles": tuple(kind(id=f"auv_{i}", agent=None) for i in range(1, 5)),
        "leaders": ("auv_1",),
        "reference": kind(kind="circle"),
        "follows": "velocity",
        "agent": kind(
            flocking=kind(kind="own", params=kind(spacing_m=2.0)),
            separation=None,
            consensus=None,
            controller=kind(kind="velocity_pi"),
            fleet=None,
            course=None,
        ),
        "reference_of": lambda: kind(at=lambda t_s: kind(position=(0.0, 0.0, 10.0))),
        "acoustics": kind(
            preset="lossy", mac=kind(kind="tdma"), outage=kind(kind="bernoulli"), sonar=kind(kind="none")
        ),
        "environment": kind(
            current_ned_mps=(0.03, 0.04, 0.0),
            obstacles=(Obstacle(position_ned_m=(5.0, 0.0, 10.0)),),
            current=kind(kind="steady"),
            navigation=kind(kind="exact"),
        ),
    }
    return SimpleNamespace(**{**values, **changes})


def make_metrics(scenario: Any, *, apart_m: float = 2.0) -> dict[str, Any]:
    recording = Recording.empty([vehicle.id for vehicle in scenario.vehicles], np.arange(121.0))
    square = np.array([(0.0, 0.0, 10.0), (1.0, 0.0, 10.0), (1.0, 1.0, 10.0), (0.0, 1.0, 10.0)])
    recording.position_ned_m[:] = square * (apart_m, apart_m, 1.0)
    recording.nav_position_ned_m[:] = recording.position_ned_m[:-1] + 0.1
    recording.events = np.array([(0, 0, 1, 0, 1, 32)])  # sent, and not yet arrived
    recording.event_values = np.array([(0.0, 0.5, np.nan)])
    return compute_metrics(recording, scenario, mode="lockstep", real_time_factor=12.0)


def make_results(folder: Path) -> Path:
    results = folder / "by_hand-7-lockstep"
    (results / "bag").mkdir(parents=True)
    (results / "scenario.yaml").write_text("schema: 1\nname: by_hand  # <&>\n", encoding="utf-8")
    return results


def one_figure(folder: Path, title: str = "Tracks in the plane") -> SavedFigures:
    path = folder / "plan.png"
    path.write_bytes(ONE_PIXEL)
    return SavedFigures((Figure(path, title, "What to see."),))


def read(path: Path) -> tuple[str, Outline]:
    page = path.read_text(encoding="utf-8")
    outline = Outline()
    outline.feed(page)
    outline.close()
    return page, outline


@pytest.fixture
def report(tmp_path: Path) -> tuple[str, Outline]:
    scenario = make_scenario()
    return read(write_report(make_results(tmp_path), scenario, make_metrics(scenario), one_figure(tmp_path)))


def test_it_lies_in_the_results_folder(tmp_path: Path) -> None:
    results = make_results(tmp_path)
    scenario = make_scenario()
    assert write_report(results, scenario, make_metrics(scenario), SavedFigures()) == results / "report.html"


def test_nothing_is_fetched(report: tuple[str, Outline]) -> None:
    page, outline = report
    assert "http://" not in page
    assert "https://" not in page
    assert "url(" not in page
    assert set(outline.tags).isdisjoint({"script", "link", "iframe", "object", "embed", "base", "form"})
    references = [v for _, name, v in outline.attributes if name in ("src", "href", "srcset", "data")]
    assert len(references) == 1
    assert all(value is not None and value.startswith("data:image/png;base64,") for value in references)


def test_the_figure_inside_is_the_file_outside(report: tuple[str, Outline]) -> None:
    page, _ = report
    (encoded,) = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    assert base64.b64decode(encoded) == ONE_PIXEL
    assert "Tracks in the plane" in page
    assert "What to see." in page


def test_every_metric_that_has_a_value_is_shown_and_no_other(report: tuple[str, Outline]) -> None:
    page, _ = report
    for key, value in make_metrics(make_scenario()).items():
        assert (f"<code>{key}</code>" in page) == (value is not None)
    assert not re.search(r"\b(nan|None|inf)\b|–</td>", page)


def test_numbers_stay_on_a_line_and_long_texts_are_broken(tmp_path: Path) -> None:
    scenario = make_scenario()
    metrics = {"lyapunov_proof_gap": "why " * 40, "ring_reached_s": [1.0] * 40, "force_max_n": 1.0}
    page, _ = read(write_report(make_results(tmp_path), scenario, metrics, SavedFigures()))
    assert page.count("<td class='words'>") == 2
    assert page.count("<td class='value'>") == 1


def test_figures_come_before_numbers(report: tuple[str, Outline]) -> None:
    page, _ = report
    assert page.index("<h2>Result</h2>") < page.index("<h2>Figures</h2>") < page.index("<h2>Numbers</h2>")


def test_a_hostile_scenario_stays_text(tmp_path: Path) -> None:
    scenario = make_scenario(title=HOSTILE, name="</pre><script>", leaders=("<b>",))
    results = make_results(tmp_path)
    (results / "scenario.yaml").write_text(f"title: {HOSTILE}\n</pre>", encoding="utf-8")
    (results / "provenance.json").write_text(
        json.dumps({"overrides": [HOSTILE], "platform": HOSTILE, "packages": {"numpy": HOSTILE}})
    )
    page, outline = read(
        write_report(results, scenario, make_metrics(scenario), one_figure(tmp_path, title=HOSTILE))
    )
    assert "<script" not in page
    assert outline.tags.count("img") == 1
    assert not [name for _, name, _ in outline.attributes if name.startswith("on")]
    assert HOSTILE in outline.text


def test_it_says_how_to_repeat_and_replay(tmp_path: Path) -> None:
    results = make_results(tmp_path)
    scenario = make_scenario()
    provenance = {
        "overrides": ["acoustics.outage.params.loss_prob=0.3", "title='two words'"],
        "duration_was_set": True,
        "python": "3.11.2",
        "packages": {"numba": "1.4.5"},
        "git": {"revision": "abc123", "has_local_changes": True},
    }
    (results / "provenance.json").write_text(json.dumps(provenance), encoding="utf-8")
    _, outline = read(write_report(results, scenario, make_metrics(scenario), SavedFigures()))
    command = "./scripts/run by_hand --seed 7 --mode lockstep --duration 120 "
    assert command + "--set acoustics.outage.params.loss_prob=0.3 --set " in outline.text
    assert "./scripts/replay results/by_hand-7-lockstep/bag" in outline.text
    assert "--re-estimate" in outline.text
    for version in ("3.11.2", "1.4.5", "abc123", "with local changes", np.__version__):
        assert version in outline.text


def test_arrays_in_place_of_a_bag(tmp_path: Path) -> None:
    results = make_results(tmp_path)
    (results / "bag").rmdir()
    (results / "recording.npz").write_bytes(b"")
    scenario = make_scenario()
    _, outline = read(write_report(results, scenario, make_metrics(scenario), SavedFigures()))
    assert "Recording.load('results/by_hand-7-lockstep/recording.npz')" in outline.text
    assert "scripts/replay" not in outline.text


@pytest.mark.parametrize(
    ("apart_m", "answer", "kind"), [(2.0, "<b>No.</b>", "good"), (0.5, "<b>Yes.</b>", "bad")]
)
def test_it_says_whether_hulls_touched(tmp_path: Path, apart_m: float, answer: str, kind: str) -> None:
    scenario = make_scenario()
    metrics = make_metrics(scenario, apart_m=apart_m)
    page, _ = read(write_report(make_results(tmp_path), scenario, metrics, SavedFigures()))
    assert f'<li class="{kind}">Did hulls touch? {answer}' in page


def test_it_says_how_vehicles_knew_where_they_were(tmp_path: Path) -> None:
    scenario = make_scenario()
    _, outline = read(write_report(make_results(tmp_path), scenario, make_metrics(scenario), SavedFigures()))
    assert "They knew" not in outline.text
    fixes = SimpleNamespace(fix="lbl", fix_period_s=60.0)
    scenario.environment.navigation = SimpleNamespace(kind="dead_reckoning", params=fixes)
    scenario.acoustics.sonar = SimpleNamespace(kind="active", params=SimpleNamespace(max_range_m=10.0))
    _, outline = read(
        write_report(tmp_path / "by_hand-7-lockstep", scenario, make_metrics(scenario), SavedFigures())
    )
    words = (
        "They knew their own position by dead reckoning with lbl fixes every 60 s and saw each other by sonar"
    )
    assert f"{words} up to 10 m." in outline.text


def test_it_says_whether_the_current_varied(tmp_path: Path) -> None:
    scenario, results = make_scenario(), make_results(tmp_path)
    _, outline = read(write_report(results, scenario, make_metrics(scenario), SavedFigures()))
    assert "a current of 0.05 m/s." in outline.text
    scenario.environment.current = SimpleNamespace(kind="gauss_markov")
    _, outline = read(write_report(results, scenario, make_metrics(scenario), SavedFigures()))
    assert "a current of 0.05 m/s that varies." in outline.text


def test_the_thesis_stands_beside_its_own_scenarios(tmp_path: Path) -> None:
    scenario = make_scenario(name="ch5_one_leader", sampling="continuous")
    _, outline = read(write_report(make_results(tmp_path), scenario, make_metrics(scenario), SavedFigures()))
    assert "1.5908" in outline.text
    assert "1.611" in outline.text
    assert "every integration stage" in outline.text


def test_on_a_narrow_screen_tables_and_images_scroll_by_themselves(report: tuple[str, Outline]) -> None:
    page, _ = report
    for match in re.finditer(r"<(img|table)\b", page):
        assert page[: match.start()].rstrip().endswith(('<div class="scroll">', "<div class='scroll'>"))
