"""Claims about the safety study: what its numbers mean, and a few of its runs flown short."""

from typing import Any

import pytest
from matplotlib.figure import Figure as Canvas

from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.scenario.loading import load_scenario
from auv_thesis.acoustics import safety as acoustics_safety
from auv_thesis.acoustics import safety_runs as study
from auv_thesis.items import (
    AGREES,
    AGREES_IN_PART,
    DIFFERS,
    DOES_NOT_HOLD,
    HOLDS,
    HOLDS_IN_PART,
    NO_NUMBER,
    Run,
)
from auv_thesis.runs.store import resolve_run


def _run(spec, ever_m=1.5, formed_m=1.6, late_m=3.0, path_m=0.05):
    metrics = {
        "pair_distance_min_m": ever_m,
        "pair_distance_min_after_150s_m": formed_m,
        "pair_distance_max_after_200s_m": late_m,
        "centroid_path_formed_rms_m": path_m,
    }
    nothing: Any = None
    return Run(spec, nothing, nothing, metrics)


def _runs(studies, **numbers):
    return [_run(spec, **numbers) for specs in studies.values() for spec in specs]


def _table(number):
    return next(table for table in acoustics_safety.TABLES if table.number == number)


def test_bars_are_those_of_each_cell():
    runs = _runs(study.OURS)
    assert [row.verdict for row in _table("A.41").rows(runs)] == [AGREES] * 6
    few = [_run(specs[0]) for specs in study.OURS.values()]
    assert [row.verdict for row in _table("A.41").rows(few)] == [AGREES_IN_PART] * 6
    assert acoustics_safety.CLAIMS[1].judge(few).holds == HOLDS_IN_PART
    worse = _table("A.41").rows(_runs(study.OURS, ever_m=0.9, path_m=0.2))
    assert [row.verdict for row in worse] == [DIFFERS] * 5 + [AGREES]
    assert _table("A.41").rows(runs)[1].thesis == "1 m, 1.4 m, at most 10 m, path 0.1 m"


@pytest.mark.parametrize(("far", "verdict"), [(3, AGREES), (4, DIFFERS)])
def test_worst_cell_may_lose_three_of_a_hundred(far, verdict):
    runs = [_run(spec, late_m=12.0 if k < far else 5.0) for k, spec in enumerate(study.OURS[study.WORST])]
    summary = study.summary_of(runs)
    assert summary.n_far == far
    assert summary.keeps(study.BARS[study.WORST]) == (verdict == AGREES)
    assert f"over 10 m in {far} of 100 (" in summary.remark


def test_a_flock_that_never_formed_is_not_near_its_path():
    specs = study.OURS[study.USUAL]
    runs = [_run(spec, path_m=None if k < 6 else 0.05) for k, spec in enumerate(specs)]
    summary = study.summary_of(runs)
    assert not summary.keeps(study.BARS[study.USUAL])
    assert "never formed in 6 of 100 (2.2 to 13 %)" in summary.remark
    assert study.summary_of(runs[2:]).path_p95_m == 0.05


def test_studies_shrink_with_the_seeds_and_say_what_was_not_flown():
    tables = {table.number: table for table in acoustics_safety.TABLES}
    look = {number: [s for s in table.runs if s.nth < 2] for number, table in tables.items()}
    assert len(look["A.41"]) == 12
    assert len(look["A.42"]) == 12
    assert len(look["A.43"]) == 2 * 12 + 3
    rows = {number: tables[number].rows([_run(spec) for spec in specs]) for number, specs in look.items()}
    assert all("not flown" not in row.ours for number in rows for row in rows[number])
    assert _table("A.45").rows([])[0].ours == "not flown"
    assert len(rows["A.44"]) == 2 * (1 + len(study.PARTS))
    assert {row.verdict for row in rows["A.44"]} == {NO_NUMBER}


def test_navigations_that_drift_have_bars_in_every_cell():
    drifting = [*_runs(study.WITH_SONAR, path_m=4.5), *_runs(study.WITH_FIXES, ever_m=0.7, formed_m=1.0)]
    rows = _table("A.43").rows(drifting)
    assert [row.verdict for row in rows] == [AGREES] * 12 + [NO_NUMBER] * 3
    assert [row.thesis for row in rows[:6]] == [
        *["1 m, 1.4 m, at most 10 m"] * 5,
        "0.6 m, 1.2 m, at most 10 m in 97 %",
    ]
    assert [row.thesis for row in rows[6:12]] == [
        "0.6 m, 0.9 m, at most 10 m",
        "0.6 m, 0.9 m, at most 10 m, path 0.8 m",
        *["0.6 m, 0.9 m, at most 10 m"] * 3,
        "0.6 m, 0.9 m, at most 10 m in 97 %",
    ]
    swapped = [*_runs(study.WITH_SONAR, ever_m=0.7, formed_m=1.0), *_runs(study.WITH_FIXES, path_m=4.5)]
    rows = _table("A.43").rows(swapped)
    assert [row.verdict for row in rows[:12]] == [DIFFERS] * 6 + [AGREES, DIFFERS] + [AGREES] * 4
    sonar, fixes = acoustics_safety.CLAIMS[2:]
    assert sonar.judge(drifting).holds == fixes.judge(drifting).holds == HOLDS
    assert "limits kept in 0 of 6 cells" in sonar.judge(swapped).evidence
    assert "limits kept in 5 of 6 cells" in fixes.judge(swapped).evidence


def test_law_without_a_part_is_compared_in_the_same_seeds():
    part = next(iter(study.PARTS))
    runs = [_run(spec) for spec in study.OURS[study.USUAL][:20]]
    runs += [_run(spec) for spec in study.ABLATED[study.USUAL, part][:3]]
    assert _table("A.44").rows(runs)[0].note.startswith("hulls touch in none of 3 (under 64 %)")


def test_claims_count_cells_and_contacts():
    thesis, ours = acoustics_safety.CLAIMS[:2]
    found = ours.judge(_runs(study.OURS))
    assert found.holds == HOLDS
    assert (
        "hulls touch in none of 600 (under 0.5 %) and in none of 100 (under 3 %) of a cell" in found.evidence
    )
    verdict = thesis.judge(_runs(study.THESIS, ever_m=0.2))
    assert verdict.holds == DOES_NOT_HOLD
    assert "hulls touch in all 600 (over 99.5 %)" in verdict.evidence
    assert "limits kept in 0 of 6 cells" in verdict.evidence


def test_every_run_of_the_study_resolves():
    chapter_runs = [spec for table in acoustics_safety.TABLES for spec in table.runs if spec.nth == 0]
    resolved = [resolve_run(spec) for spec in chapter_runs]
    assert {len(run.scenario.vehicles) for run in resolved} == {4, 8, 16}
    assert {run.scenario.seed for run in resolved} == {study.FIRST_SEED, study.FIRST_DRIFTING_SEED}
    assert not any(spec.keep_recording for spec in chapter_runs)


def _fly(spec, duration_s):
    scenario = load_scenario(spec.scenario, overrides=spec.overrides, duration_s=duration_s)
    recording = run_in_process(scenario)
    metrics = compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)
    return Run(spec, scenario, recording, metrics)


def test_flock_gathers_on_a_modem_and_the_figures_are_drawn():
    ours = _fly(study.OURS[study.USUAL][0], 60.0)
    assert ours.metrics["pair_distance_min_m"] > 1.0
    assert ours.metrics["formed_at_s"] < 60.0
    distances, nearest = acoustics_safety.FIGURES
    distances.draw(Canvas(), [ours, ours])
    nearest.draw(Canvas(), [*_runs(study.THESIS), *_runs(study.OURS)])


@pytest.mark.slow
@pytest.mark.parametrize("seed", [501, 502])
def test_worst_cell_is_safe_where_the_thesiss_law_collides(seed):
    cell = ("acoustics.mac.params.slot_s=2.0", "acoustics.outage.params.loss_prob=0.6")
    nearest_m = {}
    for name, changes in (("thesis", study.THESIS_LAW), ("ours", ())):
        scenario = load_scenario("flock_modem", overrides=(*cell, *changes), seed=seed)
        recording = run_in_process(scenario)
        metrics = compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)
        nearest_m[name] = metrics["pair_distance_min_m"]
    assert nearest_m["thesis"] < study.HULLS_TOUCH_M
    assert nearest_m["ours"] > 1.0
