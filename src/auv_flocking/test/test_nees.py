"""
Consistency: the errors are as large as the filter says.

On truth that follows the filter's own model, 100 runs: the run-averaged normalised estimation error squared
(NEES, six numbers) lies inside its 95 % interval at nine instants in ten, and likewise the normalised
innovation squared (NIS) of packets (six numbers) and of sonar contacts (three).
"""

import numpy as np
import pytest
from neighbour_truth import Setting, fly
from scipy import stats

from auv_flocking.neighbours import NeighbourConfig, NeighbourTable

CONFIG = NeighbourConfig()
RATE = CONFIG.drift_rate_mps
DRIFT = {"own_rate_mps": RATE, "sender_rate_mps": RATE}
FIXES = {"own_fixes_s": (13.0, 33.0), "sender_fixes_s": (21.0, 27.0)}
SETTINGS = {
    "packets": Setting(),
    "packets, half of them lost": Setting(loss_prob=0.5),
    "packets and sonar": Setting(sonar_every_s=0.5),
    "drift": Setting(**DRIFT),
    "drift and sonar": Setting(sonar_every_s=0.5, **DRIFT),
    "drift and fixes": Setting(**DRIFT, **FIXES),
    "drift, fixes and sonar": Setting(sonar_every_s=0.5, **DRIFT, **FIXES),
}


def band(size, runs):
    """Return the 95 % interval of the mean of so many squares of so many normal numbers each."""
    return np.array(stats.chi2.interval(0.95, size * runs)) / runs


def squares(setting, runs, duration_s, seed):
    """
    Return NEES (runs, instants), one a second, and the NIS of packets and of contacts.

    NIS come as lists of (index of the measurement, value).
    """
    nees, nis = [], {6: [], 3: []}
    for run in range(runs):
        table = NeighbourTable(CONFIG)
        row, count = [], {6: 0, 3: 0}
        for t_s, nav, arrived, contacts, truth in fly(setting, CONFIG, (seed, run), duration_s):
            for report in arrived:
                table.receive(report)
                _take(table, report.time_s, count, nis)
            used = table.contacts_used
            table.observe(t_s, nav, contacts)
            if table.contacts_used > used:
                _take(table, t_s, count, nis)
            estimates = table.estimates(t_s, nav)
            if round(10 * t_s) % 10 == 5 and t_s > 5.0:
                row.append(np.nan)
                for estimate in estimates:
                    error = np.array((*estimate.position, *estimate.velocity)) - truth
                    row[-1] = error @ np.linalg.solve(estimate.covariance, error)
        nees.append(row)
    return np.array(nees), nis


def _take(table, time_s, count, nis):
    """Note the NIS of the newest measurement of that time."""
    belief = next(b for b in reversed(table._tracks[2]._beliefs) if b.time_s == time_s)
    if belief.innovation is not None and len(belief.innovation) in nis:
        size = len(belief.innovation)
        nis[size].append((count[size], belief.nis))
        count[size] += 1


def share_inside(values, size):
    """Return how many instants have a mean over the runs inside the band of those runs, of all instants."""
    inside = []
    for column in values.T:
        known = column[np.isfinite(column)]
        if len(known) > 0.5 * len(column):
            low, high = band(size, len(known))
            inside.append(low < known.mean() < high)
    return np.mean(inside)


def nis_share_inside(pairs, size, runs):
    """Return the same for innovations, by their number in a run."""
    by_index = {}
    for index, value in pairs:
        by_index.setdefault(index, []).append(value)
    full = [values for values in by_index.values() if len(values) > 0.5 * runs]
    inside = [band(size, len(values))[0] < np.mean(values) < band(size, len(values))[1] for values in full]
    return np.mean(inside)


def test_the_band_for_100_runs_of_six_numbers():
    np.testing.assert_allclose(band(6, 100), (5.34, 6.70), atol=0.005)


@pytest.mark.parametrize("name", ["packets, half of them lost", "drift, fixes and sonar"])
def test_the_errors_are_as_large_as_the_filter_says_few_runs(name):
    nees, nis = squares(SETTINGS[name], 12, 40.0, 21)
    low, high = stats.norm.interval(0.9999, 6.0, np.sqrt(12.0 * 4.0 / nees.size))
    assert low < np.nanmean(nees) < high
    for size, pairs in nis.items():
        if pairs:
            spread = np.sqrt(2.0 * size / len(pairs))
            assert abs(np.mean([value for _, value in pairs]) - size) < 4.0 * spread


@pytest.mark.slow
@pytest.mark.parametrize("name", SETTINGS)
def test_the_errors_are_as_large_as_the_filter_says(name):
    runs = 100
    nees, nis = squares(SETTINGS[name], runs, 90.0, 22)
    # With fixes the offset's reset is exact for the position only; still nearly as consistent.
    share = 0.8 if "fixes" in name else 0.9
    assert share_inside(nees, 6) >= share
    assert np.nanmean(nees) == pytest.approx(6.0, rel=0.05)
    for size, pairs in nis.items():
        if pairs:
            assert nis_share_inside(pairs, size, runs) >= share
