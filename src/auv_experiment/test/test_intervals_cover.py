"""
Claims about how often intervals cover: simulated, with the true value known.

The fast tests have 1000 samples a case (standard error 0.7 %) and some of the cases, the slow ones 20 000.
docs/how_to/sweeps.md has the slow ones' figures.
"""

import numpy as np
import pytest
from scipy.stats import binom, bootstrap, norm

from auv_experiment.confidence.binomial import wilson_interval
from auv_experiment.confidence.clusters import mean_interval, percentile_interval, share_interval
from auv_experiment.confidence.differences import difference_interval

FEW, MANY = 1000, 20_000
NEAR_95 = 91.6, 98.4
"""Allowed in the fast tests: 93 to 97 % and about twice their standard error."""
NORMAL, EXPONENTIAL, MILD, STRONG = "normal", "exponential", "lognormal 0.5", "lognormal 1"
DRAWN = {
    NORMAL: lambda rng, shape: rng.normal(size=shape),
    EXPONENTIAL: lambda rng, shape: rng.exponential(size=shape) - 1.0,
    MILD: lambda rng, shape: (rng.lognormal(0.0, 0.5, shape) - np.exp(0.125)) / 0.604,
    STRONG: lambda rng, shape: (rng.lognormal(0.0, 1.0, shape) - np.exp(0.5)) / 2.161,
}
"""Of mean 0 and variance 1."""

CROSSED = [
    (10, 20, (1.0, 0.0, 0.0), 94.7),
    (10, 20, (0.8, 0.0, 0.2), 94.8),
    (10, 20, (0.45, 0.1, 0.45), 94.8),
    (10, 20, (0.1, 0.6, 0.3), 95.2),
    (10, 20, (0.0, 0.0, 1.0), 97.8),
    (20, 20, (0.33, 0.33, 0.34), 94.9),
    (20, 20, (0.0, 0.0, 1.0), 96.9),
    (10, 5, (0.45, 0.1, 0.45), 95.6),
]
"""Draws, seeds, shares of the variance that are the draw's, the seed's and the run's, coverage in percent."""
SKEWED = [
    (NORMAL, 5, 94.3),
    (NORMAL, 20, 95.1),
    (EXPONENTIAL, 10, 94.5),
    (EXPONENTIAL, 20, 94.6),
    (EXPONENTIAL, 50, 94.9),
    (EXPONENTIAL, 100, 95.2),
    (MILD, 10, 93.7),
    (MILD, 20, 94.1),
    (MILD, 100, 94.8),
    (STRONG, 10, 91.5),
    (STRONG, 20, 92.2),
    (STRONG, 50, 93.0),
    (STRONG, 100, 93.5),
]
PERCENTILES = [(0.5, 10, 96.0), (0.5, 20, 95.2), (0.5, 100, 95.1), (0.95, 100, 95.6), (0.95, 300, 95.1)]
CORRELATED_SHARES = [
    (0.1, 0.0, 98.8),
    (0.1, 0.2, 95.5),
    (0.1, 0.5, 91.3),
    (0.3, 0.5, 95.2),
    (0.5, 0.9, 96.9),
    (0.03, 0.9, 97.1),
    (0.1, 0.9, 85.9),
]
"""Share, correlation of runs of one draw (of the normal variable below a threshold), coverage in percent."""


def crossed(rng, draws, seeds, parts, kind=NORMAL):
    """Return values of draws x seeds runs with mean 0, and the numbers of their draws and seeds."""
    effects = [(draws, 1), (1, seeds), (draws, seeds)]
    values = sum(np.sqrt(part) * DRAWN[kind](rng, shape) for part, shape in zip(parts, effects, strict=True))
    draw, seed = np.divmod(np.arange(draws * seeds), seeds)
    return np.ravel(values), draw, seed


def covered(interval, truth):
    return (interval.low is None or interval.low <= truth) and (
        interval.high is None or truth <= interval.high
    )


def width(interval):
    return interval.high - interval.low


def coverage(samples, one):
    """Return the coverage (%) over samples; `one` says from a generator whether one interval covers."""
    rng = np.random.default_rng(14)
    return 100.0 * np.mean([one(rng) for _ in range(samples)])


def of_crossed(samples, draws, seeds, parts):
    def one(rng):
        return covered(mean_interval(*crossed(rng, draws, seeds, parts)), 0.0)

    return coverage(samples, one)


def of_skewed(samples, kind, n):
    return coverage(samples, lambda rng: covered(mean_interval(DRAWN[kind](rng, n)), 0.0))


def of_percentile(samples, share, n):
    truth = -np.log1p(-share)
    return coverage(samples, lambda rng: covered(percentile_interval(rng.exponential(size=n), share), truth))


def of_correlated_share(samples, share, correlation, draws=10):
    threshold = norm.ppf(share)

    def one(rng):
        values, draw, seed = crossed(rng, draws, 20, (correlation, 0.0, 1.0 - correlation))
        return covered(share_interval(values < threshold, draw, seed), share)

    return coverage(samples, one)


@pytest.mark.parametrize(("draws", "seeds", "parts", "expected"), CROSSED[1::2])
def test_means_over_draws_and_seeds_cover(draws, seeds, parts, expected):
    found = of_crossed(FEW, draws, seeds, parts)
    assert found == pytest.approx(expected, abs=3.0)
    assert NEAR_95[0] <= found <= (99.0 if parts[2] == 1.0 else NEAR_95[1])


def test_runs_taken_as_independent_do_not_cover():
    def one(rng):
        return covered(mean_interval(crossed(rng, 10, 20, (0.45, 0.1, 0.45))[0]), 0.0)

    assert coverage(FEW, one) < 50.0


def test_a_mean_pooled_over_levels_with_shared_seeds_covers():
    seed = np.tile(np.arange(20), 5)

    def one(rng):
        values = 1.5 * rng.normal(size=20)[seed] + rng.normal(size=100)
        levels = np.repeat(np.arange(5.0), 20)
        return covered(mean_interval(values + levels, seed), 2.0), covered(mean_interval(values), 0.0)

    rng = np.random.default_rng(14)
    clustered, independent = 100.0 * np.mean([one(rng) for _ in range(FEW)], axis=0)
    assert NEAR_95[0] <= clustered <= NEAR_95[1]
    assert independent < 70.0


@pytest.mark.parametrize(("kind", "n", "expected"), SKEWED[1::3])
def test_means_of_skewed_values_cover(kind, n, expected):
    found = of_skewed(FEW, kind, n)
    assert found == pytest.approx(expected, abs=3.0)
    assert kind == STRONG or NEAR_95[0] <= found <= NEAR_95[1]


@pytest.mark.parametrize(("share", "n", "expected"), PERCENTILES[1::2])
def test_percentiles_cover(share, n, expected):
    found = of_percentile(FEW, share, n)
    assert found == pytest.approx(expected, abs=3.0)
    assert NEAR_95[0] <= found <= NEAR_95[1]


@pytest.mark.parametrize(
    ("n", "expected"),
    [
        (20, (0.896, 0.957, 0.983)),
        (50, (0.895, 0.956, 0.980)),
        (100, (0.921, 0.954, 0.978)),
        (300, (0.930, 0.951, 0.976)),
    ],
)
def test_wilsons_interval_oscillates_for_shares_of_1_to_10_percent(n, expected):
    low, high = wilson_interval(np.arange(n + 1), np.full(n + 1, n))
    shares = np.linspace(0.01, 0.1, 181)[:, np.newaxis]
    covers = (binom.pmf(np.arange(n + 1), n, shares) * ((low <= shares) & (shares <= high))).sum(axis=1)
    assert (covers.min(), covers.mean(), covers.max()) == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize(("share", "correlation", "expected"), CORRELATED_SHARES[1::2])
def test_shares_over_draws_cover_as_often_as_the_page_says(share, correlation, expected):
    assert of_correlated_share(FEW, share, correlation) == pytest.approx(expected, abs=3.0)


def test_a_median_over_draws_covers():
    def one(rng):
        values, draw, seed = crossed(rng, 10, 20, (0.5, 0.0, 0.5))
        return covered(percentile_interval(values, 0.5, draw, seed), 0.0)

    assert NEAR_95[0] <= coverage(FEW, one) <= NEAR_95[1]


@pytest.mark.parametrize("share", [0.02, 0.1, 0.4])
def test_differences_of_paired_shares_cover(share):
    def one(rng):
        seed, own = rng.normal(size=30), rng.normal(size=(2, 30))
        first, second = (seed + own) / np.sqrt(2.0) < norm.ppf([[share], [0.5 * share]])
        interval = difference_interval(first, second, np.arange(30), is_truth=True)
        return covered(interval, 0.5 * share)

    assert coverage(FEW, one) >= NEAR_95[0]


def test_differences_of_pairs_cover_and_are_narrower_than_the_means_suggest():
    def one(rng):
        seed = 3.0 * rng.normal(size=20)
        first, second = seed + 1.0 + rng.normal(size=20), seed + rng.normal(size=20)
        paired = difference_interval(first, second, np.arange(20))
        return covered(paired, 1.0), width(paired) / width(mean_interval(first))

    rng = np.random.default_rng(14)
    found = np.array([one(rng) for _ in range(FEW)])
    assert NEAR_95[0] <= 100.0 * found[:, 0].mean() <= NEAR_95[1]
    assert found[:, 1].mean() < 0.5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("measure", "cases"),
    [
        (of_crossed, CROSSED),
        (of_skewed, SKEWED),
        (of_percentile, PERCENTILES),
        (of_correlated_share, CORRELATED_SHARES),
    ],
)
def test_coverages_are_those_that_the_page_states(measure, cases):
    for *case, expected in cases:
        found = measure(MANY, *case)
        assert found == pytest.approx(expected, abs=0.6), case


@pytest.mark.slow
@pytest.mark.parametrize("kind", [EXPONENTIAL, STRONG])
def test_hall_covers_more_often_than_bca(kind):
    def one(rng):
        values = DRAWN[kind](rng, 20)
        found = bootstrap((values,), np.mean, n_resamples=499, vectorized=True, rng=rng).confidence_interval
        return found.low <= 0.0 <= found.high

    assert of_skewed(3000, kind, 20) > coverage(3000, one) + 1.5
