"""The filter's stated errors in flight: shares beyond its ellipsoids, and the verdict that follows."""

import numpy as np
import pytest

from auv_thesis.acoustics import estimation_in_flight as study
from auv_thesis.acoustics.estimation_runs import DURATION_S
from auv_thesis.items import DOES_NOT_HOLD, HOLDS, HOLDS_IN_PART

N = 20_000


def test_a_gaussian_has_the_stated_shares_beyond_its_ellipsoids():
    square = np.random.default_rng(1).chisquare(3, 200_000)
    assert study.beyond(square, 0.95) == pytest.approx(0.05, abs=0.002)
    assert study.beyond(square, 0.997) == pytest.approx(0.003, abs=0.0005)
    assert np.isnan(study.beyond(np.array([]), 0.95))


def _flown(scale, tail):
    """Return eight flights whose errors are `scale` times as large as stated, and a share of them far off."""
    rng = np.random.default_rng(2)
    t_s = np.linspace(0.0, DURATION_S, N, endpoint=False)
    flights = []
    for _ in study.SEEDS:
        square = scale**2 * rng.chisquare(3, N) + 100.0 * (rng.random(N) < tail)
        flights.append(study.Squares(t_s, np.ones(N), square))
    return flights


@pytest.mark.parametrize(
    ("scale", "tail", "verdict"),
    [(1.0, 0.0, HOLDS), (0.5, 0.0, HOLDS_IN_PART), (1.5, 0.0, DOES_NOT_HOLD), (0.5, 0.01, DOES_NOT_HOLD)],
)
def test_caution_holds_in_part_and_sure_tails_do_not(monkeypatch, scale, tail, verdict):
    monkeypatch.setattr(study, "_by_case", lambda _runs: {case: _flown(scale, tail) for case in study.CASES})
    assert study._judge([]).holds == verdict
