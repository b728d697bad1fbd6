"""
Consistency: the errors are as large as the filter says.

On truth that follows the filter's own model, 100 runs: the run-averaged normalised estimation error squared
(NEES, six numbers) lies inside its 95 % interval at nine instants in ten, and likewise the normalised
innovation squared (NIS) of packets (six numbers) and of sonar contacts (three).
"""

from typing import Any

import numpy as np
import pytest
from scipy import stats

from auv_flocking.neighbours.synthetic_neighbour import Setting
from auv_flocking.neighbours.table import NeighbourConfig
from auv_thesis.acoustics.consistency import CONTACT, PACKET, STATES, band, share_inside, squares

CONFIG = NeighbourConfig()
RATE = CONFIG.drift_rate_mps
DRIFT: dict[str, Any] = {"own_rate_mps": RATE, "sender_rate_mps": RATE}
FIXES: dict[str, Any] = {"own_fixes_s": (23.0, 63.0), "sender_fixes_s": (31.0, 57.0)}
SETTINGS = {
    "packets": Setting(),
    "packets, half of them lost": Setting(loss_prob=0.5),
    "packets and sonar": Setting(sonar_every_s=0.5),
    "drift": Setting(**DRIFT),
    "drift and sonar": Setting(sonar_every_s=0.5, **DRIFT),
    "drift and fixes": Setting(**DRIFT, **FIXES),
    "drift, fixes and sonar": Setting(sonar_every_s=0.5, **DRIFT, **FIXES),
}


def test_the_band_for_100_runs_of_six_numbers():
    np.testing.assert_allclose(band(6, 100), (5.34, 6.70), atol=0.005)


def test_a_filter_that_believes_too_much_is_found_out():
    """Truth with four times the acceleration: hardly an instant is inside the band."""
    seeds = np.random.SeedSequence(20).spawn(12)
    wild = NeighbourConfig(acceleration_psd=4e-3)
    honest = squares(SETTINGS["packets"], CONFIG, seeds, 30.0)
    assert share_inside(honest.nees, STATES) > 0.7
    wrong = squares(SETTINGS["packets"], CONFIG, seeds, 30.0, truth=wild)
    assert share_inside(wrong.nees, STATES) < 0.3


def test_a_velocity_that_comes_back_is_as_consistent():
    config = NeighbourConfig(velocity_memory_s=5.0)
    found = squares(Setting(packets_every_s=4.0), config, np.random.SeedSequence(23).spawn(12), 60.0)
    assert np.nanmean(found.nees) == pytest.approx(6.0, abs=0.8)


@pytest.mark.parametrize("name", ["packets, half of them lost", "drift, fixes and sonar"])
def test_the_errors_are_as_large_as_the_filter_says_few_runs(name):
    found = squares(SETTINGS[name], CONFIG, np.random.SeedSequence(21).spawn(12), 40.0)
    for values, size, correlated in (
        (found.nees, STATES, 4.0),
        (found.packets, PACKET, 1.0),
        (found.contacts, CONTACT, 1.0),
    ):
        known = values[np.isfinite(values)]
        if len(known):
            low, high = stats.norm.interval(0.9999, size, np.sqrt(correlated * 2.0 * size / len(known)))
            assert low < known.mean() < high


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("name", SETTINGS)
def test_the_errors_are_as_large_as_the_filter_says(name):
    """
    Three times a hundred runs: instants of one run are not independent, so that the share of one hundred is a
    random within a few per cent (0.89 to 0.98 were observed).
    """
    # After fixes the offset is reset as if its rate were not known from the fix: nearly consistent.
    least = 0.8 if "fixes" in name else 0.9
    found = [
        squares(SETTINGS[name], CONFIG, np.random.SeedSequence(seed).spawn(100), 150.0) for seed in (1, 5, 22)
    ]
    for kind, size in (("nees", STATES), ("packets", PACKET), ("contacts", CONTACT)):
        hundreds = [getattr(each, kind) for each in found]
        if np.isfinite(hundreds[0]).any():
            assert np.mean([share_inside(values, size) for values in hundreds]) >= least
            together = np.concatenate([np.ravel(values) for values in hundreds])
            assert np.nanmean(together) == pytest.approx(size, rel=0.05)
