"""The filter's stated errors in flight: the verdict that follows from shares beyond its ellipsoids."""

import numpy as np
import pytest

from auv_experiment.metrics.neighbours import TAILS, JudgedErrors
from auv_thesis.acoustics import estimation_in_flight as study
from auv_thesis.acoustics.estimation_runs import DURATION_S
from auv_thesis.items import DOES_NOT_HOLD, HOLDS, HOLDS_IN_PART

N = 20_000


def test_the_levels_are_those_of_the_metrics_points():
    square = np.random.default_rng(1).chisquare(3, 200_000)
    assert tuple(study.LEVELS) == tuple(TAILS)
    for tail, level in study.LEVELS.items():
        (share,) = study._shares([square, np.array([])], tail)
        assert share == pytest.approx(1.0 - level, rel=0.1)


def _flown(scale, tail):
    """Return eight flights whose errors are `scale` times as large as stated, and a share of them far off."""
    rng = np.random.default_rng(2)
    t_s = np.linspace(0.0, DURATION_S, N, endpoint=False)
    flights = []
    for _ in study.SEEDS:
        square = scale**2 * rng.chisquare(3, N) + 100.0 * (rng.random(N) < tail)
        flights.append(JudgedErrors(t_s, np.ones(N), square))
    return flights


@pytest.mark.parametrize(
    ("scale", "tail", "verdict"),
    [(1.0, 0.0, HOLDS), (0.5, 0.0, HOLDS_IN_PART), (1.5, 0.0, DOES_NOT_HOLD), (0.5, 0.01, DOES_NOT_HOLD)],
)
def test_caution_holds_in_part_and_sure_tails_do_not(monkeypatch, scale, tail, verdict):
    monkeypatch.setattr(study, "_by_case", lambda _runs: {case: _flown(scale, tail) for case in study.CASES})
    assert study._judge([]).holds == verdict


def test_the_table_has_phases_and_the_bins_of_the_metrics(monkeypatch):
    monkeypatch.setattr(study, "_by_case", lambda _runs: {case: _flown(1.0, 0.0) for case in study.CASES})
    quantities = [row.quantity for row in study._rows([])]
    wanted = ("gathering", "formed", "age of the information 0 to 2 s")
    assert quantities == [f"{case}, {words}" for case in study.CASES for words in wanted]
