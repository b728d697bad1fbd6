"""Claims about the comparison of laws for groups, in formation and in a flock."""

from __future__ import annotations

import numpy as np
import pytest

from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.scenario.loading import load_scenario
from auv_thesis.items import DOES_NOT_HOLD, HOLDS, HOLDS_IN_PART, Run
from auv_thesis.laws import formation_laws, formation_runs, group_flock_laws, group_flock_runs
from auv_thesis.laws.separation_runs import NOISE

ORIGIN = "own run of 2026-11, sampled at 10 Hz"


def _fly(spec):
    scenario = load_scenario(spec.scenario, overrides=spec.overrides, duration_s=spec.duration_s)
    recording = run_in_process(scenario)
    metrics = compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)
    return Run(spec, scenario, recording, metrics)


@pytest.mark.parametrize(
    "spec",
    [spec for file in (formation_laws, group_flock_laws) for table in file.TABLES for spec in table.runs][
        ::7
    ],
    ids=str,
)
def test_runs_can_be_resolved(spec):
    assert load_scenario(spec.scenario, overrides=spec.overrides, duration_s=spec.duration_s).ticks > 0


@pytest.mark.parametrize(
    ("law", "condition", "rms_mm"),
    [
        (formation_runs.FIXED, "hulls +30 %, 0, -30 %", 4.7),
        (formation_runs.SLIDING_SPRINGS, "hulls +30 %, 0, -30 %", 2.9),
        (formation_runs.H_INFINITY, "current 0.1 m/s", 1.9),
    ],
)
def test_errors_of_a_formation(law, condition, rms_mm):
    result = formation_laws.numbers_of(_fly(formation_runs.RUNS[law, condition]))
    assert result.rms_mm == pytest.approx(rms_mm, rel=0.05), ORIGIN
    assert result.worst_mm >= result.rms_mm


def test_within_its_layer_sliding_mode_is_the_law_with_a_fixed_model():
    fixed, sliding = (
        _fly(formation_runs.RUNS[law, "current 0.1 m/s"])
        for law in (formation_runs.FIXED, formation_runs.SLIDING)
    )
    is_late = fixed.recording.t_s >= formation_runs.JUDGED_AFTER_S
    places_m = [run.recording.position_ned_m[is_late] for run in (fixed, sliding)]
    np.testing.assert_allclose(places_m[1], places_m[0], rtol=0.0, atol=1e-4)


def test_learning_from_an_obstacle_keeps_a_flock_farther_away():
    clearance_m = [
        _fly(group_flock_runs.PAST[law, NOISE][0]).metrics["obstacle_clearance_min_m"]
        for law in (group_flock_runs.AT_REST, group_flock_runs.LEARNING)
    ]
    assert clearance_m[1] > clearance_m[0] + 0.1


@pytest.mark.slow
def test_verdicts_of_a_formation_and_of_a_flock():
    claims = (*formation_laws.CLAIMS, *group_flock_laws.CLAIMS)
    runs = {spec: _fly(spec) for spec in dict.fromkeys(spec for claim in claims for spec in claim.runs)}
    verdicts = [claim.judge([runs[spec] for spec in claim.runs]).holds for claim in claims]
    assert verdicts == [HOLDS_IN_PART, HOLDS, HOLDS_IN_PART, DOES_NOT_HOLD, HOLDS_IN_PART]
