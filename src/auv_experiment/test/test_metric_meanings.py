"""Every metric of every shipped scenario has a description, and every description has a metric."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.descriptions import FAMILIES, MEANINGS, family_meaning
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.metrics.wording import meaning_of, shown_metrics
from auv_experiment.scenario.loading import list_scenarios, load_scenario

OF_OWN_FILES = {"own_metrics_failed"}


@pytest.fixture(scope="module")
def metrics_by_scenario() -> dict[str, dict[str, Any]]:
    found = {}
    for name, _ in list_scenarios():
        scenario = load_scenario(name)
        short = replace(scenario, duration_s=3.0 * scenario.period_s)
        recording = run_in_process(short)
        found[name] = compute_metrics(recording, short, mode="inprocess", real_time_factor=1.0)
    return found


def test_every_metric_of_a_shipped_scenario_has_a_meaning(
    metrics_by_scenario: dict[str, dict[str, Any]],
) -> None:
    without = {
        f"{name}: {key}"
        for name, metrics in metrics_by_scenario.items()
        for key in metrics
        if key not in MEANINGS and family_meaning(key) is None
    }
    assert without == set()


def test_every_meaning_is_of_a_metric(metrics_by_scenario: dict[str, dict[str, Any]]) -> None:
    yielded = {key for metrics in metrics_by_scenario.values() for key in metrics}
    assert set(MEANINGS) - yielded == OF_OWN_FILES


def test_meanings_are_short_and_need_no_other() -> None:
    for key, meaning in {**MEANINGS, **FAMILIES}.items():
        assert 5 < len(meaning.words) <= 110, key
        assert not meaning.words.startswith("the same"), key
        assert not meaning.words.endswith("."), key
    assert len({meaning.words for meaning in MEANINGS.values()}) == len(MEANINGS)


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("lyapunov_energy_falls", "Lyapunov candidate energy "),
        (
            "flock_lyapunov_thesis_largest_rise_ratio",
            "largest increase of candidate thesis within one record",
        ),
        ("x_err_5p4_m", "x error (path minus position) of the first vehicle at 5.4 s"),
        ("no_such_key_m", "no such key m"),
    ],
)
def test_a_key_that_holds_a_name_has_words(key: str, words: str) -> None:
    assert meaning_of(key).words.startswith(words)


def test_metrics_are_shown_in_the_order_of_their_meanings() -> None:
    assert [key for key, _ in shown_metrics({"own_m": 1, "collision": True, "formed_at_s": 2.0})] == [
        "formed_at_s",
        "collision",
        "own_m",
    ]
