"""Claims about intervals of a share: textbook values, and bounds that never cover less than they say."""

import doctest

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, binomtest

from auv_experiment.confidence import binomial
from auv_experiment.confidence.binomial import exact_bounds, exact_upper_bound, share_words, wilson_interval

SHARES = np.linspace(0.001, 0.999, 999)


def counts(most=200):
    return st.integers(1, most).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n)))


def test_wilson_interval_as_printed_in_textbooks():
    low, high = wilson_interval([0, 10, 80], [10, 10, 100])
    np.testing.assert_allclose(low, [0.0, 0.7225, 0.7112], atol=1e-4)
    np.testing.assert_allclose(high, [0.2775, 1.0, 0.8666], atol=1e-4)


@given(counts())
def test_exact_bounds_are_those_of_scipys_test(count):
    k, n = count
    expected = binomtest(k, n).proportion_ci(0.95, method="exact")
    assert exact_bounds(k, n) == pytest.approx((expected.low, expected.high), abs=1e-12)
    one_sided = binomtest(k, n, alternative="less").proportion_ci(0.95, method="exact")
    assert exact_upper_bound(k, n) == pytest.approx(one_sided.high, abs=1e-12)


@given(st.integers(1, 10**6))
def test_none_of_n_bounds_the_share_by_three_over_n(n):
    assert exact_upper_bound(0, n) == pytest.approx(1.0 - 0.05 ** (1.0 / n), rel=1e-9)
    assert exact_upper_bound(0, n) < 3.0 / n


@pytest.mark.parametrize("n", [5, 20, 100])
def test_exact_bounds_cover_at_least_what_they_say(n):
    bounds = np.array([exact_bounds(k, n) for k in range(n + 1)])
    upper = np.array([exact_upper_bound(k, n) for k in range(n + 1)])
    chance = binom.pmf(np.arange(n + 1), n, SHARES[:, np.newaxis])
    inside = (bounds[:, 0] <= SHARES[:, np.newaxis]) & (SHARES[:, np.newaxis] <= bounds[:, 1])
    assert (chance * inside).sum(axis=1).min() >= 0.95
    assert (chance * (SHARES[:, np.newaxis] <= upper)).sum(axis=1).min() >= 0.95


@pytest.mark.parametrize(("k", "n"), [(-1, 5), (6, 5), (0, 0)])
def test_no_count_has_no_bounds(k, n):
    with pytest.raises(ValueError, match="no count of runs"):
        exact_bounds(k, n)


@given(counts(10_000))
def test_words_never_say_less_than_the_bounds(count):
    k, n = count
    words = share_words(k, n)
    numbers = [
        float(word) / 100.0 for word in words.partition("(")[2].replace("%)", "").split() if word[0].isdigit()
    ]
    if k == 0:
        assert numbers[0] >= exact_upper_bound(0, n) - 1e-9
    elif k < n:
        low, high = exact_bounds(k, n)
        assert numbers[0] <= low + 1e-9
        assert numbers[1] >= high - 1e-9


def test_the_words_of_the_examples_are_right():
    assert doctest.testmod(binomial).failed == 0
