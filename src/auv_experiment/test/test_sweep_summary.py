"""Claims about what a sweep shows: known confidence intervals, and a page whose numbers are the table's."""

import csv
import json
import math
import shutil
from dataclasses import replace
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from full_disk import files_of_at_most
from hypothesis import given, settings
from hypothesis import strategies as st

from auv_experiment.figures.files import draw_in_style
from auv_experiment.results import ResultsError
from auv_experiment.sweeps import cli
from auv_experiment.sweeps import table as sweep_table
from auv_experiment.sweeps.figures import draw_metric
from auv_experiment.sweeps.labels import (
    group_label,
    legend_title,
    metric_label,
    parameter_label,
    short_values,
)
from auv_experiment.sweeps.plan import PlannedRun
from auv_experiment.sweeps.statistics import distribution_band, summarise
from auv_experiment.sweeps.study import study_from_plain
from auv_experiment.sweeps.summary import groups_by
from auv_experiment.sweeps.table import read_table, write_table
from auv_experiment.sweeps.worker import Finished

PLAIN = {
    "schema": 1,
    "name": "made_up",
    "title": "Made <up>",
    "scenario": "flock_modem",
    "grid": {"a.slot_s": [1, 2], "b.kind": ["x", None]},
    "seeds": [1, 2, 3],
    "metrics": ["pair_distance_min_m", "collision"],
}


def made_up(**changes):
    """Return a study and its rows: the metric is 10 slot + seed, and one run failed."""
    study = study_from_plain({**PLAIN, **changes})
    rows: list[Any] = []
    for slot in (1, 2):
        for kind in ("x", None):
            for seed in (1, 2, 3):
                run = PlannedRun(
                    len(rows), {"a.slot_s": slot, "b.kind": kind}, seed, f"k{len(rows)}", 1.0, ""
                )
                metrics: dict[str, Any] = {"pair_distance_min_m": 10.0 * slot + seed, "collision": seed == 3}
                rows.append((run, Finished(metrics, wall_s=1.0, cpu_s=1.0)))
    rows[-1] = (rows[-1][0], Finished({}, "ValueError: it <sank>", "Traceback\n"))
    return study, rows


def test_the_interval_of_the_mean_of_few_runs_is_students():
    summary = summarise([1.0, 2.0, 3.0, None])
    half = 4.302652729911275 / math.sqrt(3)  # t of 0.975 with 2 degrees of freedom
    assert (summary.n, summary.mean) == (3, 2.0)
    assert (summary.low, summary.high) == pytest.approx((2.0 - half, 2.0 + half))
    assert (summary.method, summary.clusters) == ("Student's t", "3 runs")
    assert (summary.smallest, summary.median, summary.largest) == (1.0, 2.0, 3.0)


def test_the_interval_of_a_share_is_wilsons():
    summary = summarise([True] + [False] * 9)
    assert (summary.mean, summary.low, summary.high) == pytest.approx((0.1, 0.01788, 0.40415), abs=1e-5)


def test_no_collision_in_few_runs_does_not_mean_none():
    assert summarise([False] * 20).high == pytest.approx(0.1611, abs=1e-4)


def test_no_collision_in_ten_draws_with_twenty_seeds_is_none_of_ten():
    draws, seeds = np.divmod(np.arange(200), 20)
    summary = summarise([False] * 200, {"draws": draws.tolist(), "seeds": seeds.tolist()})
    assert summary.high == pytest.approx(summarise([False] * 10).high)
    assert summary.clusters == "10 draws x 20 seeds"


def test_one_run_has_no_interval_and_none_has_no_mean():
    assert (summarise([4.0]).mean, summarise([4.0]).low) == (4.0, None)
    assert (summarise([None]).n, summarise([None]).mean) == (0, None)


@given(st.lists(st.floats(0.0, 1.0), min_size=2, max_size=9))
def test_an_interval_of_a_share_lies_between_0_and_1(values):
    summary = summarise(values, is_share=True)
    assert summary.low is not None
    assert summary.high is not None
    assert 0.0 <= summary.low <= summary.high <= 1.0


@given(st.lists(st.floats(-10.0, 10.0), min_size=2, max_size=9), st.floats(0.1, 10.0), st.floats(-5.0, 5.0))
def test_intervals_follow_the_unit_of_a_metric(values, scale, shift):
    one, other = summarise(values), summarise([scale * value + shift for value in values])
    for name in ("mean", "low", "high"):
        expected = scale * getattr(one, name) + shift
        assert getattr(other, name) == pytest.approx(expected, rel=1e-3, abs=1e-3)


def test_the_band_of_a_distribution_is_dvoretzky_kiefer_wolfowitz():
    assert distribution_band(100) == pytest.approx(0.13581, abs=1e-5)


def test_a_table_comes_back_with_its_study(tmp_path):
    study, rows = made_up()
    write_table(tmp_path, study, rows, {"Python": "3"})
    table = read_table(tmp_path)
    assert (table.study, table.making, table.n_runs) == (study, {"Python": "3"}, 12)
    assert table.metrics == ["pair_distance_min_m", "collision"]
    assert table.columns["scenario.b.kind"][:6] == ["x"] * 3 + [None] * 3
    assert table.columns["pair_distance_min_m"][-1] is None
    assert table.columns["status"][-2:] == ["done", "failed"]


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """Return the bytes of a table, what is in it, and a folder to put others into."""
    folder = tmp_path_factory.mktemp("table")
    study, rows = made_up()
    return write_table(folder, study, rows, {"Python": "3"}).read_bytes(), read_table(folder), folder


@settings(deadline=None)
@given(st.data())
def test_a_flipped_bit_is_found_or_changes_nothing(good, data):
    whole, expected, folder = good
    place = data.draw(st.integers(0, 8 * len(whole) - 1))
    changed = bytearray(whole)
    changed[place // 8] ^= 1 << place % 8
    (folder / "runs.parquet").write_bytes(changed)
    try:
        found = read_table(folder)
    except ResultsError:
        return
    assert (found.study, found.making, found.columns) == (expected.study, expected.making, expected.columns)


def rewritten(folder, change):
    """Write the table again after a change of it, with a checksum that holds."""
    study, rows = made_up()
    table = pq.read_table(write_table(folder, study, rows, {"Python": "3"}))
    about = json.loads(table.schema.metadata[b"shoal"])
    del about["checksum"]
    table = change(table, about)
    about["checksum"] = sweep_table._checksum(table, about)
    table = table.replace_schema_metadata({b"shoal": json.dumps(about).encode()})
    pq.write_table(table, folder / "runs.parquet")


def with_column(name, values):
    def change(table, about):
        return table.drop_columns([name] if name in table.column_names else []).append_column(name, [values])

    return change


def with_about(**changes):
    def change(table, about):
        about.update(changes)
        return table

    return change


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (with_column("seed", ["one"] * 12), "column seed: string is the wrong type"),
        (with_column("error", [None] * 12), "column error: null is the wrong type"),
        (with_column("key", ["a"] * 11 + [None]), "column key: a value is missing"),
        (with_column("status", ["fine"] * 12), "column status: 'fine' is not a status"),
        (with_column("cpu_s", ["long"] * 12), "column cpu_s: string is the wrong type"),
        (with_column("collision", [[1]] * 12), "column collision: list<element: int64> is not a number"),
        (with_column("../collision", [1] * 12), "column '../collision': not the name of a metric"),
        (lambda table, about: table.drop_columns(["scenario.b.kind"]), "column scenario.b.kind: missing"),
        (lambda table, about: table.slice(0, 0), "no rows"),
        (with_about(texts=["a.slot_s"]), "JSON"),
        (with_about(texts=7), "TypeError"),
        (with_about(making={"Python": 3}), "making: not texts by name"),
        (with_about(study={}), "ConfigError"),
    ],
)
def test_a_table_of_wrong_types_is_refused_in_one_line(tmp_path, capsys, change, words):
    rewritten(tmp_path, change)
    assert cli.main(["--summarise", str(tmp_path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"error: {tmp_path / 'runs.parquet'}: not the table of a sweep (")
    assert words in line


@pytest.mark.parametrize(
    ("n", "word", "words"),
    [(200_000, "a", "200000 rows; allowed: up to 100000"), (2000, "a" * 20_000, "it unpacks to more than")],
)
def test_a_small_file_that_unpacks_to_much_is_refused(tmp_path, monkeypatch, n, word, words):
    monkeypatch.setattr(sweep_table, "_MOST_BYTES", 1 << 24)
    pq.write_table(pa.table({"error": [word] * n}), tmp_path / "runs.parquet")
    assert (tmp_path / "runs.parquet").stat().st_size < 1 << 20
    with pytest.raises(ResultsError, match=words):
        read_table(tmp_path)


def test_a_table_of_an_earlier_version_has_no_checksum_and_is_read(tmp_path):
    study, rows = made_up()
    table = pq.read_table(write_table(tmp_path, study, rows, {}))
    about = json.loads(table.schema.metadata[b"shoal"])
    del about["checksum"]
    pq.write_table(
        table.replace_schema_metadata({b"shoal": json.dumps(about).encode()}), tmp_path / "runs.parquet"
    )
    assert read_table(tmp_path).n_runs == 12


def test_numbers_whole_or_not_are_one_column_and_mixed_values_are_text(tmp_path):
    study, rows = made_up(grid={"a.slot_s": [1, 2.5], "b.kind": ["x", {"kind": "y"}]})
    for row, (run, _) in enumerate(rows):
        run.parameters.update({"a.slot_s": (1, 2.5)[row // 6], "b.kind": ("x", {"kind": "y"})[row // 3 % 2]})
    schema = pq.read_schema(write_table(tmp_path, study, rows, {}))
    assert str(schema.field("scenario.a.slot_s").type) == "double"
    table = read_table(tmp_path)
    assert set(table.columns["scenario.b.kind"]) == {'"x"', '{"kind": "y"}'}
    assert [table.parameters(row) for row in range(12)] == [run.parameters for run, _ in rows]


def summarised(folder, capsys, **changes):
    study, rows = made_up(**changes)
    write_table(folder, study, rows, {"Python": "3"})
    status = cli.main(["--summarise", str(folder)])
    return status, capsys.readouterr().err


def test_the_summary_has_each_metric_at_each_point(tmp_path, capsys):
    summarised(tmp_path, capsys)
    rows = list(csv.DictReader((tmp_path / "summary.csv").open()))
    assert len(rows) == 4 * 2
    last = [row for row in rows if row["metric"] == "pair_distance_min_m"][-1]
    assert (last["scenario.a.slot_s"], last["scenario.b.kind"]) == ("2", "")
    assert (last["runs"], last["failed"], last["n"], last["mean"]) == ("3", "1", "2", "21.5")


def test_differences_pair_runs_with_the_same_seed(tmp_path, capsys):
    summarised(tmp_path, capsys)
    rows = list(csv.DictReader((tmp_path / "differences.csv").open()))
    (row,) = [
        row
        for row in rows
        if (row["metric"], row["differs_in"]) == ("pair_distance_min_m", "scenario.a.slot_s")
        and row["scenario.b.kind"] == "x"
    ]
    assert (row["scenario.a.slot_s"], row["from"], row["pairs"], row["clusters"]) == (
        "2",
        "1",
        "3",
        "3 seeds",
    )
    assert [float(row[key]) for key in ("difference", "low", "high")] == [10.0, 10.0, 10.0]
    (failed,) = [row for row in rows if row["metric"] == "pair_distance_min_m" and row["pairs"] == "2"][:1]
    assert failed["clusters"] == "2 seeds"


def test_runs_of_a_draw_are_a_cluster(tmp_path, capsys):
    distribution = {"a.slot_s": {"uniform": [1.0, 2.0]}}
    summarised(tmp_path, capsys, grid=None, sample={"count": 4, "parameters": distribution})
    table = read_table(tmp_path)
    assert [table.draw_of(row) for row in range(12)] == [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3]
    (row,) = [
        row
        for row in csv.DictReader((tmp_path / "summary.csv").open())
        if row["metric"] == "pair_distance_min_m"
    ]
    assert row["clusters"] == "4 draws x 3 seeds"
    assert not (tmp_path / "differences.csv").exists()
    drawing = draw_in_style(lambda: draw_metric(table, "pair_distance_min_m"))
    assert drawing is not None
    assert drawing.canvas.axes[0].get_xlabel() == "slot_s\n95 % intervals of the mean over 4 draws x 3 seeds"


def test_a_failed_run_is_told_with_its_command_and_by_the_exit_status(tmp_path, capsys):
    status, error = summarised(tmp_path, capsys)
    assert status == 1
    assert error == f"error: 1 of 12 runs failed; see {tmp_path / 'failures.txt'}\n"
    page = (tmp_path / "index.html").read_text()
    assert "--seed 3 --set a.slot_s=2 --set b.kind=null --mode inprocess" in page
    assert "ValueError: it &lt;sank&gt;" in page


def test_a_full_disk_ends_the_showing_in_one_line_and_leaves_nothing_half_written(tmp_path, capsys):
    study, rows = made_up()
    write_table(tmp_path, study, rows, {"Python": "3"})
    with files_of_at_most(2000):
        assert cli.main(["--summarise", str(tmp_path)]) == 3
    (line,) = capsys.readouterr().err.splitlines()
    assert line == f"error: cannot write {tmp_path / 'figures/pair_distance_min_m.png'}: File too large"
    written = ["differences.csv", "runs.parquet", "summary.csv"]
    assert sorted(path.name for path in tmp_path.rglob("*.*")) == written


def test_the_page_needs_no_other_file_and_the_table_makes_it_again(tmp_path, capsys):
    summarised(tmp_path, capsys)
    first = (tmp_path / "index.html").read_text()
    assert "http" not in first.replace("http-equiv", "")
    assert first.count("data:image/png;base64,") == 2
    assert "Made &lt;up&gt;" in first
    assert "Paired differences from the first value of a parameter" in first
    assert "Student&#x27;s t, 3 seeds" in first
    other = tmp_path / "other"
    other.mkdir()
    shutil.copy(tmp_path / "runs.parquet", other)
    cli.main(["--summarise", str(other)])
    assert (other / "index.html").read_text() == first


@pytest.mark.parametrize(
    "changes",
    [
        {"x": "b.kind"},
        {"by": "b.kind"},
        {
            "grid": None,
            "sample": {
                "count": 4,
                "parameters": {"a.slot_s": {"integers": [1, 2]}, "b.kind": {"choice": ["x", None]}},
            },
        },
    ],
    ids=["words along the axis", "lines by one parameter", "a sample"],
)
def test_every_kind_of_study_is_drawn(changes, tmp_path, capsys):
    summarised(tmp_path, capsys, **changes)
    assert {path.stem for path in (tmp_path / "figures").iterdir()} == {"pair_distance_min_m", "collision"}


def test_a_folder_without_a_table_is_refused_in_one_line(tmp_path, capsys):
    assert cli.main(["--summarise", str(tmp_path)]) == 2
    assert "cannot be read" in capsys.readouterr().err
    (tmp_path / "runs.parquet").write_text("no table")
    assert cli.main(["--summarise", str(tmp_path)]) == 2
    assert "not the table of a sweep" in capsys.readouterr().err


def labelled(folder, **changes):
    study, rows = made_up(**changes)
    write_table(folder, study, rows, {})
    return read_table(folder)


def test_labels_are_short_without_the_study(tmp_path):
    table = labelled(tmp_path)
    assert parameter_label(table, "a.slot_s") == "slot_s"
    assert [group_label(table, group) for group in groups_by(table, ["a.slot_s", "b.kind"])] == [
        "1, x",
        "1, null",
        "2, x",
        "2, null",
    ]
    assert legend_title(table, ["a.slot_s", "b.kind"]) == "slot_s, kind"
    assert metric_label(table, "collision") == "share of runs: collision"


def test_a_study_sets_its_labels(tmp_path):
    labels = {
        "a.slot_s": {"name": "slot", "values": ["short", "long"]},
        "b.kind": "law",
        "collision": "collisions per run",
    }
    table = labelled(tmp_path, labels=labels)
    groups = groups_by(table, ["a.slot_s", "b.kind"])
    assert [group_label(table, group) for group in groups][::3] == ["short, x", "long, null"]
    assert legend_title(table, ["a.slot_s", "b.kind"]) == "slot, law"
    assert metric_label(table, "collision") == "collisions per run"
    drawing = draw_in_style(lambda: draw_metric(table, "collision"))
    assert drawing is not None
    (axes,) = drawing.canvas.axes
    assert axes.get_xlabel() == "slot\n95 % intervals of the share over 3 seeds or 2 seeds"
    assert axes.get_ylabel() == "collisions per run"


@pytest.mark.parametrize(
    ("values", "texts"),
    [
        ([0.5, 1, 1e-7], ["0.5", "1", "1e-07"]),
        ([{"kind": "a", "params": {"x": 1}}, {"kind": "b", "params": {"x": 1}}], ["a", "b"]),
        (
            [{"kind": "a", "params": {"x": 1}}, {"kind": "a", "params": {"x": 2, "y": "z"}}],
            ["x 1", "x 2, y z"],
        ),
        ([{"kind": "a"}, {"kind": "a", "params": {"x": 1}}], ["", "x 1"]),
        ([[1.0, 2.0], [3.0]], ["[1.0, 2.0]", "[3.0]"]),
        (["a" * 40], ["a" * 27 + "…"]),
    ],
)
def test_the_text_of_a_value_is_what_tells_it_from_the_others(values, texts):
    assert short_values(values) == texts


def test_figures_of_another_format_are_written_and_old_ones_go(tmp_path, capsys):
    summarised(tmp_path, capsys)
    cli.main(["--summarise", str(tmp_path), "--format", "pdf"])
    names = {path.name for path in (tmp_path / "figures").iterdir()}
    metrics = ("pair_distance_min_m", "collision")
    assert names == {f"{name}.{kind}" for name in metrics for kind in ("pdf", "png")}
    cli.main(["--summarise", str(tmp_path)])
    assert {path.suffix for path in (tmp_path / "figures").iterdir()} == {".png"}


def test_own_metrics_that_failed_are_one_warning(tmp_path, capsys):
    study, rows = made_up()
    rows = [
        (run, replace(f, metrics={**f.metrics, "own_metrics_failed": "metrics/a.py: x"})) for run, f in rows
    ]
    write_table(tmp_path, study, rows, {})
    cli.main(["--summarise", str(tmp_path)])
    assert "warning: own metrics failed in 12 of 12 runs: metrics/a.py: x\n" in capsys.readouterr().err
