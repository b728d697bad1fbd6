"""Claims about studies of many seeds: as many as were asked for, and of each run no more kept than wanted."""

import io
from dataclasses import replace

import pytest

from auv_core.cli.failures import DONE
from auv_core.cli.tally import Tally
from auv_experiment.recording import RecordingError
from auv_thesis import cli
from auv_thesis.items import NO_NUMBER, Chapter, Row, RunSpec, Table, with_seeds
from auv_thesis.runs import runner
from auv_thesis.runs.store import Store

ONE = RunSpec("ch5_one_leader", ("dt_s=0.1",), 1.0)
FIRST = replace(ONE, keep_recording=False)
SECOND = replace(ONE, overrides=("dt_s=0.1", "seed=2"), keep_recording=False, nth=1)
THIRD = replace(ONE, overrides=("dt_s=0.1", "seed=3"), keep_recording=False, nth=2)


def _rows(runs):
    return [Row(str(run.spec), "", f"{run.metrics['duration_s']:g} s", NO_NUMBER) for run in runs]


STUDY = Chapter("study", "Study", (), (Table("S.1", "Many seeds", (FIRST, SECOND, THIRD), _rows),), ())


def fly(specs, folder):
    with Tally("runs", io.StringIO()) as tally:
        return runner.fly_all(specs, Store(folder), n_workers=1, tally=tally)


def test_a_study_flies_as_many_seeds_as_were_asked_for():
    (fewer,) = with_seeds((STUDY,), 2)
    assert fewer.runs == (FIRST, SECOND)
    assert with_seeds((STUDY,), 3)[0].runs == STUDY.runs


def test_metrics_alone_are_kept_where_no_recording_is_wanted(tmp_path):
    store, flown = Store(tmp_path), fly([FIRST], tmp_path)
    key = flown.resolved[FIRST].key
    assert store.metrics(key)["duration_s"] == pytest.approx(1.0)
    with pytest.raises(RecordingError):
        store.recording(key)
    assert fly([FIRST], tmp_path).kept == {key}


def test_who_wants_the_recording_gets_it_though_another_does_not(tmp_path):
    store = Store(tmp_path)
    key = fly([FIRST], tmp_path).resolved[FIRST].key
    flown = fly([ONE, FIRST], tmp_path)
    assert not flown.kept
    assert store.recording(key).n_vehicles == 4
    assert fly([FIRST], tmp_path).kept == {key}


@pytest.mark.parametrize("text", ["0", "101", "many", "2.0"])
def test_number_of_seeds_that_is_not_allowed_is_refused_in_one_line(text, capsys, tmp_path):
    with pytest.raises(SystemExit) as end:
        cli.main(["--seeds", text, "--out", str(tmp_path)], (STUDY,))
    assert end.value.code == 2
    error = capsys.readouterr().err
    assert "--seeds" in error
    assert "a whole number from 1 to 100" in error


def test_command_takes_the_number_of_seeds(tmp_path, capsys):
    assert cli.main(["--seeds", "1", "--workers", "1", "--out", str(tmp_path)], (STUDY,)) == DONE
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "seed=2" not in page
    assert cli.main(["--list", "--seeds", "3"], (STUDY,)) == DONE
    assert "(3 runs)" in capsys.readouterr().out
