"""The comparison of path-following laws: its runs exist, and its numbers are what each law is good for."""

from __future__ import annotations

import pytest

from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.scenario.loading import load_scenario
from auv_thesis.items import HOLDS, HOLDS_IN_PART, Run
from auv_thesis.laws.path_laws import CLAIMS, numbers_of
from auv_thesis.laws.path_runs import ALL_LAWS, CASES, EQUAL, GAINS, LAWS, RUNS, gains_of

SPECS = dict(zip(CASES, RUNS, strict=True))
ORIGIN = "own run of 2026-11, sampled at 10 Hz"


def _fly(case, *overrides):
    return _fly_spec(SPECS[case], *overrides)


def _fly_spec(spec, *overrides):
    scenario = load_scenario(spec.scenario, overrides=[*spec.overrides, *overrides])
    return Run(spec, scenario, run_in_process(scenario), {})


def test_every_case_is_a_scenario():
    for spec in RUNS:
        assert load_scenario(spec.scenario, overrides=spec.overrides).name == "compare_path_laws"


@pytest.mark.parametrize(
    ("law", "condition", "rms_mm", "clearance_m"),
    [
        ("PD (pfpd)", "nominal", 79.7, 0.720),
        ("augmented PD (pfapd)", "current 0.1 m/s", 79.4, 0.756),
        ("sliding mode", "current 0.1 m/s", 24.1, 0.735),
        ("sliding mode", "plant +30 %", 7.6, 0.722),
        ("H-infinity", "current 0.1 m/s", 3.1, 0.642),
        ("H-infinity", "noise 5 cm, 1 cm/s", 14.9, 0.632),
    ],
)
def test_errors_and_distances(law, condition, rms_mm, clearance_m):
    result = numbers_of(_fly((law, condition)))
    assert 1e3 * result.rms_m == pytest.approx(rms_mm, rel=0.02), ORIGIN
    assert result.clearance_m == pytest.approx(clearance_m, abs=0.005), ORIGIN
    assert result.worst_m >= result.rms_m


def test_effort_is_what_the_actuators_give():
    free = numbers_of(_fly(("PD (pfpd)", "nominal"), "duration_s=100.0")).effort_n2s
    limited = numbers_of(_fly(("PD (pfpd)", "limits 200 N"), "duration_s=100.0")).effort_n2s
    assert limited < 0.2 * free
    assert limited < 2 * 200.0**2 * 100.0


def test_gains_are_those_of_the_parameters():
    assert GAINS["PD (pfpd)"].stiffness_npm == pytest.approx((100.0, 150.0))
    assert GAINS["PD (pfpd)"].damping_nspm == pytest.approx((50.0, 40.0))
    # The law's F, and lambda (k / phi + drag) with the drag at 0.1 m/s and at rest.
    assert GAINS["H-infinity"].stiffness_npm == pytest.approx((309.427, 319.764), rel=1e-5)
    assert GAINS["sliding mode"].stiffness_npm == pytest.approx((0.5 * (600.0 + 80.0), 0.5 * (800.0 + 100.0)))


@pytest.mark.parametrize("law", EQUAL)
def test_rivals_are_as_stiff_as_the_law_that_they_are_named_after(law):
    model = GAINS[law.rpartition("as stiff as ")[2]]
    assert gains_of(ALL_LAWS[law]).stiffness_npm == pytest.approx(model.stiffness_npm, rel=1e-4)
    assert law not in LAWS


@pytest.mark.slow
def test_a_robust_law_is_better_than_laws_as_stiff_only_where_it_has_more():
    runs = {spec: _fly_spec(spec) for spec in dict.fromkeys(spec for claim in CLAIMS for spec in claim.runs)}
    verdicts = [claim.judge([runs[spec] for spec in claim.runs]).holds for claim in CLAIMS]
    assert verdicts == [HOLDS_IN_PART, HOLDS]
