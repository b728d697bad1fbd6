"""Claims about what a sweep shows: known confidence intervals, and a page whose numbers are the table's."""

import csv
import math
import shutil

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st

from auv_bringup.sweeps import cli
from auv_bringup.sweeps.confidence import distribution_band, summarise
from auv_bringup.sweeps.plan import PlannedRun
from auv_bringup.sweeps.study import study_from_plain
from auv_bringup.sweeps.table import read_table, write_table
from auv_bringup.sweeps.worker import Finished

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
    rows = []
    for slot in (1, 2):
        for kind in ("x", None):
            for seed in (1, 2, 3):
                run = PlannedRun(
                    len(rows), {"a.slot_s": slot, "b.kind": kind}, seed, f"k{len(rows)}", 1.0, ""
                )
                metrics = {"pair_distance_min_m": 10.0 * slot + seed, "collision": seed == 3}
                rows.append((run, Finished(metrics, wall_s=1.0, cpu_s=1.0)))
    rows[-1] = (rows[-1][0], Finished({}, "ValueError: it <sank>", "Traceback\n"))
    return study, rows


def test_the_interval_of_a_mean_is_students():
    summary = summarise([1.0, 2.0, 3.0, None])
    half = 4.302652729911275 / math.sqrt(3)  # t of 0.975 with 2 degrees of freedom
    assert (summary.n, summary.mean) == (3, 2.0)
    assert (summary.low, summary.high) == pytest.approx((2.0 - half, 2.0 + half))
    assert (summary.smallest, summary.median, summary.largest) == (1.0, 2.0, 3.0)


def test_the_interval_of_a_share_is_wilsons():
    summary = summarise([True] + [False] * 9)
    assert (summary.mean, summary.low, summary.high) == pytest.approx((0.1, 0.01788, 0.40415), abs=1e-5)


def test_no_collision_in_few_runs_does_not_mean_none():
    assert summarise([False] * 20).high == pytest.approx(0.1611, abs=1e-4)


def test_one_run_has_no_interval_and_none_has_no_mean():
    assert (summarise([4.0]).mean, summarise([4.0]).low) == (4.0, None)
    assert (summarise([None]).n, summarise([None]).mean) == (0, None)


@given(st.lists(st.floats(0.0, 1.0), min_size=2, max_size=9))
def test_an_interval_holds_the_mean_and_that_of_a_share_lies_between_0_and_1(values):
    summary = summarise(values, is_share=True)
    assert 0.0 <= summary.low <= summary.mean + 1e-12
    assert summary.mean - 1e-12 <= summary.high <= 1.0


def test_students_interval_covers_as_often_as_it_says():
    rng = np.random.default_rng(1)
    summaries = [summarise(rng.normal(5.0, 2.0, 6).tolist()) for _ in range(2000)]
    assert np.mean([s.low <= 5.0 <= s.high for s in summaries]) == pytest.approx(0.95, abs=0.015)


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


def test_a_failed_run_is_told_with_its_command_and_by_the_exit_status(tmp_path, capsys):
    status, error = summarised(tmp_path, capsys)
    assert status == 1
    assert error == f"error: 1 of 12 runs failed; see {tmp_path / 'failures.txt'}\n"
    page = (tmp_path / "index.html").read_text()
    assert "--seed 3 --set a.slot_s=2 --set b.kind=null --mode inprocess" in page
    assert "ValueError: it &lt;sank&gt;" in page


def test_the_page_needs_no_other_file_and_the_table_makes_it_again(tmp_path, capsys):
    summarised(tmp_path, capsys)
    first = (tmp_path / "index.html").read_text()
    assert "http" not in first.replace("http-equiv", "")
    assert first.count("data:image/png;base64,") == 2
    assert "Made &lt;up&gt;" in first
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
