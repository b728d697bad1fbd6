"""Figures: drawn where data exist, skipped where not, and no extreme lost in thinning."""

from __future__ import annotations

import re
import struct
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from matplotlib import rc_context

from auv_control.references import circle
from auv_core.cli.one_line_parser import OneLineParser
from auv_core.models import hovering
from auv_experiment.figures import Figure
from auv_experiment.figures.files import save_figures
from auv_experiment.figures.flock import flock_drawers
from auv_experiment.figures.formats import add_format_option
from auv_experiment.figures.plotting import (
    PAGE_STYLE,
    PAPER_STYLE,
    legend_below,
    new_canvas,
    round_step,
    thin_indices,
    wrap_words,
)
from auv_experiment.recording import Recording
from auv_experiment.scenario.schema import Obstacle

ALL = [
    "plan",
    "space",
    "pair_distances",
    "path_error",
    "consensus_error",
    "speed",
    "obstacle_distances",
]
STATE_ONLY = ["plan", "space", "pair_distances", "path_error"]


def make_scenario(name: str = "circling", *, with_obstacles: bool = True, n: int = 4) -> Any:
    obstacle = Obstacle(position_ned_m=(8.0, 5.0, 10.0), safety_distance_m=2.0)
    return SimpleNamespace(
        name=name,
        leaders=("auv_1",),
        hull_radius_m=0.3,
        handlings=n * (hovering(0.3),),
        follows="velocity",
        reference_of=lambda: circle.Reference(circle.Params()),
        environment=SimpleNamespace(obstacles=(obstacle,) if with_obstacles else ()),
        agent=SimpleNamespace(flocking=SimpleNamespace(params=SimpleNamespace(spacing_m=2.0))),
    )


def circling_flock(
    duration_s: float = 200.0, period_s: float = 0.5, n: int = 4, *, thinks: bool = True
) -> Recording:
    """Vehicles that converge on places around a point of the path, with noise."""
    rng = np.random.default_rng(3)
    n_ticks = round(duration_s / period_s)
    recording = Recording.empty([f"auv_{i + 1}" for i in range(n)], period_s * np.arange(n_ticks + 1))
    t_s = recording.t_s[:, np.newaxis, np.newaxis]
    path = np.concatenate([10.0 * np.sin(0.01 * t_s), 10.0 * np.cos(0.01 * t_s), 10.0 + 0.0 * t_s], axis=-1)
    place = rng.normal(size=(n, 3))
    place *= 1.2 / np.linalg.norm(place, axis=-1, keepdims=True)
    recording.position_ned_m[:] = path + place * (1.0 + 5.0 * np.exp(-t_s / 10.0))
    recording.attitude_quat_wxyz[:] = (1.0, 0.0, 0.0, 0.0)
    if not thinks:
        return recording
    recording.velocity_body[:] = rng.normal(0.1, 0.01, recording.velocity_body.shape)
    recording.reference_velocity_ned_mps[:] = rng.normal(
        0.1, 0.01, recording.reference_velocity_ned_mps.shape
    )
    truth = recording.position_ned_m[:-1]
    recording.centre_ned_m[:] = truth.mean(axis=1, keepdims=True) + rng.normal(0.0, 0.05, truth.shape)
    return recording


def png_size(path: Path) -> tuple[int, int]:
    content = path.read_bytes()
    assert content[:8] == b"\x89PNG\r\n\x1a\n"
    assert content[-8:-4] == b"IEND"
    width, height = struct.unpack(">II", content[16:24])
    return width, height


def draw_figures(recording: Recording, scenario: Any, folder: Path) -> list[Figure]:
    return list(save_figures(flock_drawers(recording, scenario), scenario, folder).figures)


def names(figures: list[Figure]) -> list[str]:
    return [figure.path.stem for figure in figures]


def test_every_figure_is_a_png_of_sane_size_with_words(tmp_path: Path) -> None:
    figures = draw_figures(circling_flock(), make_scenario(), tmp_path / "figures")
    assert names(figures) == ALL
    assert sorted(path.stem for path in (tmp_path / "figures").iterdir()) == sorted(ALL)
    for figure in figures:
        width, height = png_size(figure.path)
        assert 900 <= width <= 1400
        assert 500 <= height <= 1400
        assert 10_000 < figure.path.stat().st_size < 1_000_000
        assert figure.title
        assert len(figure.caption) > 40


def test_a_figure_whose_data_do_not_exist_is_skipped(tmp_path: Path) -> None:
    figures = draw_figures(circling_flock(thinks=False), make_scenario(with_obstacles=False), tmp_path)
    assert names(figures) == STATE_ONLY
    assert sorted(path.stem for path in tmp_path.iterdir()) == sorted(STATE_ONLY)


def test_a_recording_of_nothing_gives_no_figure(tmp_path: Path) -> None:
    recording = Recording.empty(["auv_1", "auv_2"], np.arange(10.0))
    assert draw_figures(recording, make_scenario(), tmp_path) == []


def test_one_vehicle_alone(tmp_path: Path) -> None:
    figures = draw_figures(circling_flock(n=1), make_scenario(n=1), tmp_path)
    assert "pair_distances" not in names(figures)
    assert "plan" in names(figures)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("n_ticks", [1, 3])
def test_the_shortest_runs(tmp_path: Path, n_ticks: int) -> None:
    figures = draw_figures(circling_flock(0.1 * n_ticks, 0.1), make_scenario(), tmp_path)
    assert set(names(figures)) >= set(STATE_ONLY)


@pytest.mark.filterwarnings("error")
def test_a_lost_vehicle_and_missing_states_draw_without_complaint(tmp_path: Path) -> None:
    recording = circling_flock()
    recording.lost_at_s[1] = 80.0
    recording.position_ned_m[50:60, 2] = np.nan
    recording.attitude_quat_wxyz[300:, 3] = np.nan
    assert names(draw_figures(recording, make_scenario(), tmp_path)) == ALL


def test_twelve_vehicles_are_too_many_for_single_lines(tmp_path: Path) -> None:
    figures = draw_figures(circling_flock(60.0, n=12), make_scenario(n=12), tmp_path)
    assert names(figures) == ALL


def test_the_thesis_figure_number_is_in_the_title(tmp_path: Path) -> None:
    figures = draw_figures(circling_flock(20.0, thinks=False), make_scenario("ch5_one_leader"), tmp_path)
    titles = {figure.path.stem: figure.title for figure in figures}
    assert titles["plan"].endswith("(thesis Fig. 5.7 (b))")
    assert titles["pair_distances"].endswith("(thesis Fig. 5.8)")
    assert "thesis" not in titles["path_error"]


def test_equal_runs_give_equal_files(tmp_path: Path) -> None:
    first = draw_figures(circling_flock(20.0, thinks=False), make_scenario(), tmp_path / "a")
    second = draw_figures(circling_flock(20.0, thinks=False), make_scenario(), tmp_path / "b")
    assert [f.path.read_bytes() for f in first] == [f.path.read_bytes() for f in second]


@settings(max_examples=50, deadline=None)
@given(
    values=hnp.arrays(
        np.float64, st.integers(1, 3000), elements=st.floats(-1e6, 1e6) | st.just(float("nan"))
    ),
    n_columns=st.integers(1, 100),
)
def test_thinning_keeps_both_ends_and_every_extreme(values: np.ndarray, n_columns: int) -> None:
    shown = thin_indices(values, n_columns)
    assert len(shown) <= 2 * n_columns + 2
    assert shown[0] == 0
    assert shown[-1] == len(values) - 1
    assert (np.diff(shown) > 0).all()
    if np.isfinite(values).any():
        assert np.nanmin(values[shown]) == np.nanmin(values)
        assert np.nanmax(values[shown]) == np.nanmax(values)


@pytest.mark.parametrize(
    ("value", "step"), [(108.3, 100.0), (3.3, 2.0), (0.07, 0.05), (50.0, 50.0), (0.0, 1.0)]
)
def test_round_steps(value: float, step: float) -> None:
    assert round_step(value) == pytest.approx(step)


def test_files_for_a_paper_fit_one_column_and_have_their_letters_in_them(tmp_path: Path) -> None:
    for folder in (tmp_path / "a", tmp_path / "b"):
        drawers = flock_drawers(circling_flock(60.0), make_scenario(), only=["pair_distances"])
        save_figures(drawers, make_scenario(), folder, ("png", "pdf", "svg"))
    pdf, svg = ((tmp_path / "a" / f"pair_distances.{kind}").read_bytes() for kind in ("pdf", "svg"))
    assert re.search(rb"/MediaBox \[ 0 0 252 \d+", pdf)  # 3.5 in
    assert b"/FontFile2" in pdf
    assert b"/Type3" not in pdf
    assert re.search(rb'<svg [^>]*width="252pt"', svg)
    assert b"<text" not in svg
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes()


def test_words_longer_than_their_axes_are_broken() -> None:
    with rc_context(PAPER_STYLE):
        canvas = new_canvas(2.0)
        axes = canvas.subplots()
        axes.set_ylabel("distance between the hull centres of a pair (m)")
        axes.set_title("short")
        wrap_words(canvas)
    assert axes.get_ylabel().count("\n") >= 1
    assert axes.get_title() == "short"


def test_a_legend_has_as_many_columns_as_fit() -> None:
    def columns(style: dict[str, Any], names: list[str]) -> int:
        with rc_context(style):
            canvas = new_canvas()
            handles = canvas.subplots().plot(np.zeros((2, len(names))))
            legend_below(canvas, handles, names)
        legend: Any = canvas.legends[0]
        return int(legend._ncols)

    assert columns(PAGE_STYLE, ["auv_1", "auv_2", "auv_3", "auv_4"]) == 4
    assert columns(PAPER_STYLE, ["a name of some length", "x", "another one like it", "y"]) == 2
    assert columns(PAPER_STYLE, ["a name " * 8, "another " * 7]) == 1


@pytest.mark.parametrize("text", ["tiff", "pdf,tiff", "", "pdf;svg"])
def test_other_formats_are_refused_in_one_line(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    parser = OneLineParser()
    add_format_option(parser)
    assert parser.parse_args(["--format", "svg,pdf"]).formats == ("png", "svg", "pdf")
    with pytest.raises(SystemExit, match="2"):
        parser.parse_args([f"--format={text}"])
    (line,) = capsys.readouterr().err.splitlines()
    assert f"{text!r} is not allowed; allowed: png, pdf, svg, and several with commas" in line
