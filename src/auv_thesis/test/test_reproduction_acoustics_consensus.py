"""Claims about the study of consensus filters on a modem: what its numbers mean, and that its runs exist."""

from typing import Any

import numpy as np
import pytest

from auv_core.messages import Outcome
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.recording import Recording
from auv_experiment.scenario.loading import load_scenario
from auv_thesis.acoustics import consensus as study
from auv_thesis.acoustics import consensus_runs as runs
from auv_thesis.items import AGREES, DIFFERS, Run

IDS = ("auv_1", "auv_2", "auv_3", "auv_4")
SQUARE = np.array([[5.0, 0.0, 10.0], [0.0, 5.0, 10.0], [-5.0, 0.0, 10.0], [0.0, -5.0, 10.0]])


def _run(errors_m):
    """Return a run of vehicles at rest whose estimates are wrong by `errors_m` (K, N, 3)."""
    recording = Recording.empty(IDS, 0.5 * np.arange(len(errors_m) + 1))
    recording.position_ned_m[:] = SQUARE
    recording.centre_ned_m[:] = SQUARE.mean(axis=0) + errors_m
    scenario: Any = None  # which the numbers of vehicles at rest do not need
    return Run(runs.at_rest("{kind: thesis}", 0.0, 1), scenario, recording, {})


def _errors(start_m, end_m, settle_at_s):
    t_s = 0.5 * np.arange(1200)
    size_m = np.where(t_s < settle_at_s, start_m, end_m)
    directions = SQUARE - SQUARE.mean(axis=0)
    return size_m[:, None, None] * directions / 5.0


def test_opposite_errors_are_disagreement_and_no_bias():
    found = runs.numbers(_run(_errors(8.0, 0.1, 40.0)))
    assert found.bias_m == pytest.approx(0.0, abs=1e-9)
    assert found.disagreement_m == pytest.approx(0.1)
    assert found.error_rms_m == pytest.approx(0.1)
    assert found.settled_s == 40.0
    assert found.rate_ps == pytest.approx(np.log(20.0) / 40.0)


def test_the_rate_is_that_towards_where_estimates_settle_right_or_wrong():
    found = runs.numbers(_run(_errors(8.0, 3.0, 40.0)))
    assert found.rate_ps == pytest.approx(np.log(20.0) / 40.0)
    assert found.settled_s is None


def test_a_common_error_is_bias():
    errors = _errors(8.0, 0.0, 40.0)
    errors[-1, :, 2] += 0.3
    found = runs.numbers(_run(errors))
    assert found.bias_m == pytest.approx(0.3)
    assert found.disagreement_m == pytest.approx(0.0, abs=1e-9)


def test_what_does_not_settle_never_does():
    assert runs.numbers(_run(_errors(8.0, 0.5, 40.0))).settled_s is None
    assert runs.worst([_run(_errors(8.0, 0.1, 40.0)), _run(_errors(8.0, 0.5, 40.0))]).settled_s is None
    assert runs.worst([_run(_errors(8.0, 0.1, 40.0)), _run(_errors(8.0, 0.1, 9.0))]).settled_s == 40.0


def test_roundings_of_reports_stay_within_the_bounds_of_the_table():
    """Broadcast centres with any rounding move the steady state (L + I) c = eta + sums by no more."""
    n, rng = runs.N_VEHICLES, np.random.default_rng(4)
    steps_m = np.array([0.04, 0.04, 0.08])
    assert pytest.approx(0.5 * np.linalg.norm(steps_m)) == study._ROUNDED_M
    complete = n * np.eye(n) - np.ones((n, n))
    biases_m, away_m = [], []
    for _ in range(2000):
        rounding = rng.choice([-0.5, 0.5], (n, 3)) * steps_m
        moved = np.linalg.solve(complete + np.eye(n), rounding.sum(axis=0) - rounding)
        mean = moved.mean(axis=0)
        biases_m.append(np.linalg.norm(mean))
        away_m.append(np.linalg.norm(moved - mean, axis=1).max())
    assert max(biases_m) == pytest.approx(study._BIAS_M)
    assert max(away_m) == pytest.approx(study._DISAGREEMENT_M)


@pytest.mark.parametrize(
    ("share_of_disagreement", "share_of_bias", "verdict"),
    [(0.9, 0.9, AGREES), (1.1, 0.9, DIFFERS), (0.9, 1.1, DIFFERS)],
)
def test_a_filter_off_by_more_than_rounding_differs(share_of_disagreement, share_of_bias, verdict):
    wanted_m = study.thesis_disagreement_m(_run(_errors(8.0, 0.0, 40.0)))
    errors = _errors(8.0, wanted_m + share_of_disagreement * study._DISAGREEMENT_M, 40.0)
    errors[..., 2] += share_of_bias * study._BIAS_M
    run = _run(errors)
    run.recording.events = np.array([[0, int(Outcome.SENT), 1, 0, 1, 32]])
    rows = study._static_rows([run] * (len(runs.STATIC) * len(runs.SEEDS)))
    assert rows[0].verdict == verdict


def test_the_thesis_disagreement_is_that_of_a_complete_graph():
    assert study.thesis_disagreement_m(_run(_errors(8.0, 0.0, 40.0))) == pytest.approx(1.0)


@pytest.mark.parametrize("item", [*study.FIGURES, *study.TABLES, *study.CLAIMS], ids=lambda item: item.number)
def test_every_run_of_the_study_exists(item):
    for spec in dict.fromkeys(item.runs):
        if spec.overrides and "seed=301" not in spec.overrides:
            continue
        load_scenario(spec.scenario, overrides=list(spec.overrides), duration_s=spec.duration_s)


@pytest.mark.parametrize("name", [runs.PI, runs.PUSH_SUM, runs.MEAN])
def test_a_short_run_stays_where_it_is_and_settles(name):
    spec = runs.STATIC[name, 0.0][0]
    scenario = load_scenario(spec.scenario, overrides=list(spec.overrides), duration_s=120.0)
    run = Run(spec, scenario, run_in_process(scenario), {})
    assert np.ptp(run.recording.position_ned_m, axis=0).max() < 1e-9
    found = runs.numbers(run)
    assert found.error_rms_m < 0.5
    assert found.settled_s is not None
    assert found.settled_s < 100.0
    size, rate_bps = runs.payload(run)
    assert size == {runs.PI: 38, runs.PUSH_SUM: 53, runs.MEAN: 32}[name]
    assert rate_bps == pytest.approx(size / 2.0, rel=0.05)
