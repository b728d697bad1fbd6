"""Tables A.31 and A.33: several flights in each cell, few recordings in memory."""

import weakref
from types import SimpleNamespace
from typing import Any

import pytest

from auv_thesis.acoustics import estimation as study
from auv_thesis.acoustics.estimation_runs import GRID, SEEDS
from auv_thesis.items import DOES_NOT_HOLD, HOLDS, HOLDS_IN_PART
from auv_thesis.page import made


class _Recording:
    pass


class _Store:
    def metrics(self, _key):
        return {}

    def recording(self, _key):
        return _Recording()


def _kept_runs(count):
    store: Any = _Store()
    resolved: Any = [SimpleNamespace(key=str(index), spec=None, scenario=None) for index in range(count)]
    return [made._KeptRun(each, store) for each in resolved]


def test_a_study_keeps_few_recordings_in_memory():
    runs = _kept_runs(3 * made._KEPT_RECORDINGS)
    read = [weakref.ref(run.recording) for run in runs]
    assert sum(recording() is not None for recording in read) == made._KEPT_RECORDINGS
    assert runs[-1].recording is runs[-1].recording


def _flown(monkeypatch, filter_m):
    """Return runs of two seeds whose filter errors are a function of cell and seed; the others are 1 m."""
    cells = [cell for cell in GRID for _ in range(2)]
    errors = {index: study._Three(filter_m(cell, index % 2), 1.0, 1.0) for index, cell in enumerate(cells)}
    monkeypatch.setattr(study, "_three", errors.__getitem__)
    return list(errors)


@pytest.mark.parametrize(
    ("filter_m", "verdict", "words"),
    [
        (lambda _cell, nth: 0.5 + 0.6 * nth, HOLDS, "12 of 24"),
        (lambda cell, _nth: 0.5 if cell[1] else 1.5, HOLDS_IN_PART, "16 of 24"),
        (lambda _cell, _nth: 1.5, DOES_NOT_HOLD, "none of 24"),
    ],
)
def test_the_mean_of_a_cell_is_judged(monkeypatch, filter_m, verdict, words):
    found = study._judge_reckoning(_flown(monkeypatch, filter_m))
    assert found.holds == verdict
    assert "n = 2" in found.evidence
    assert words in found.evidence


def test_a_row_has_the_mean_over_flights_with_its_interval(monkeypatch):
    row = study._grid_rows(_flown(monkeypatch, lambda _cell, nth: 0.4 + 0.2 * nth))[0]
    assert row.quantity == "slots of 0.25 s, 0 % lost"
    assert row.ours.startswith("filter 0.500 m (")
    assert row.ours.endswith(")")
    assert row.note == "n = 2"


def test_a_single_flight_has_no_interval(monkeypatch):
    monkeypatch.setattr(study, "_three", lambda _run: study._Three(0.5, 1.0, 1.0))
    runs: Any = list(GRID)
    row = study._grid_rows(runs)[0]
    assert row.ours == "filter 0.500 m, last packet held 1.000 m, dead reckoned 1.000 m; filter / held 0.50"


def test_each_cell_flies_every_seed_once():
    for flights in GRID.values():
        assert [spec.nth for spec in flights] == list(range(len(SEEDS)))
        assert len({spec.overrides for spec in flights}) == len(SEEDS)
