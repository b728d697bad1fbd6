"""The three claims of abstract and conclusions, and the words for samples."""

from types import SimpleNamespace

import numpy as np
import pytest

from auv_experiment.scenario.loading import load_scenario
from auv_thesis.intervals import difference_bounds, difference_words, mean_words, median_words
from auv_thesis.items import DOES_NOT_HOLD, HOLDS
from auv_thesis.laws import computing, conclusions
from auv_thesis.laws.separation_runs import SEEDS


@pytest.mark.parametrize("spec", conclusions.CLAIMS[2].runs[-4:], ids=str)
def test_runs_with_other_damping_differ_in_damping_only(spec):
    scenario = load_scenario(spec.scenario, overrides=spec.overrides)
    hulls = [vehicle.model.params for vehicle in scenario.vehicles]
    assert {hull.quadratic_damping for hull in hulls} == {(72.0, 72.0, 72.0, 120.0, 120.0, 120.0)}
    assert {hull.mass_kg for hull in hulls} == {125.0}


def test_a_formation_law_takes_no_longer_in_a_larger_group_and_a_flocking_law_does():
    few, many = computing.times_us(3), computing.times_us(32)
    assert set(few) == set(computing.LAWS)
    for law in (computing.MATHEMATICAL, computing.FUZZY):
        assert min(many[law]) > 2.0 * min(few[law])
    assert min(many[computing.ADAPTIVE]) < 2.0 * min(few[computing.ADAPTIVE])


@pytest.mark.parametrize(("factor", "verdict"), [(0.5, HOLDS), (2.0, DOES_NOT_HOLD)])
def test_the_claim_about_computing_follows_from_the_times(monkeypatch, factor, verdict):
    def times_us(_n):
        base = np.linspace(9.0, 11.0, computing.REPEATS)
        return {law: base * (1.0 if law == computing.ADAPTIVE else factor) for law in computing.LAWS}

    monkeypatch.setattr(conclusions, "times_us", times_us)
    assert conclusions._judge_computing([]).holds == verdict


def _runs(deviations_m, path_m):
    return [
        SimpleNamespace(
            metrics={
                "pair_distance_settled_min_m": 2.0 - deviation_m,
                "pair_distance_settled_max_m": 2.0,
                "centroid_path_rms_m": path_m,
            }
        )
        for deviation_m in deviations_m
    ]


@pytest.mark.parametrize(("of_fuzzy", "verdict"), [(0.5, HOLDS), (1.0, DOES_NOT_HOLD), (2.0, DOES_NOT_HOLD)])
def test_a_law_compensates_if_other_damping_changes_less_with_it(of_fuzzy, verdict):
    nominal = [_runs([0.1 + 0.001 * i for i in range(len(SEEDS))], 0.2) for _ in range(3)]
    change = [0.01 + 0.001 * i for i in range(len(SEEDS))]
    damped = []
    for share in (of_fuzzy, of_fuzzy, 1.0, 1.0):
        own = [0.1 + 0.001 * i + share * c for i, c in enumerate(change)]
        damped.append(
            [_runs([deviation_m], 0.2 + share * c)[0] for deviation_m, c in zip(own, change, strict=True)]
        )
    runs = [run for group in (*nominal, *damped) for run in group]
    assert conclusions._judge_damping(runs).holds == verdict


def test_words_of_a_sample_have_its_interval():
    assert mean_words([1.0, 1.0, 1.0], "m", 1) == "1.0 m"
    assert mean_words([1.0, 3.0], "m", 1) == "2.0 m (-10.7 to 14.7)"
    assert difference_bounds([2.0, 4.0, 6.0], [1.0, 3.0, 5.0]) == (1.0, 1.0)
    assert difference_words([1.0, 3.0], [3.0, 3.0], "s", 1) == "-13.7 to +11.7 s"
    assert median_words([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 99.0], "m", 0).startswith("5 m (2 to ")
    with pytest.raises(ValueError, match="have no interval; allowed: at least 2"):
        mean_words([1.0], "m")
