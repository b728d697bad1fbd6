"""Claims about the reproduction of chapters 5 and 6 and the comparison of separation laws."""

import pytest

from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.scenario.loading import load_scenario
from auv_thesis.ch4_6 import ch5, ch5_claims, ch6, ch6_claims
from auv_thesis.ch4_6.flock_runs import FUZZY_FOUR_LEADERS, MATCHED_ON
from auv_thesis.items import Run, RunSpec, chapters_of
from auv_thesis.laws import separation_laws, separation_runs

FILES = {"ch5": ch5, "ch6": ch6, "ch6_claims": ch6_claims, "separation_laws": separation_laws}
SPECS = {spec for chapter in chapters_of(FILES) for spec in chapter.runs}


def test_every_figure_and_table_of_the_two_chapters_is_there():
    numbers = {figure.number for chapter in chapters_of(FILES) for figure in chapter.figures}
    assert numbers >= {f"5.{n}" for n in range(5, 13)} | {f"6.{n}" for n in range(3, 10)}
    assert "6.1" in {table.number for chapter in chapters_of(FILES) for table in chapter.tables}


@pytest.mark.parametrize("spec", sorted(SPECS, key=str), ids=str)
def test_every_run_can_be_resolved(spec):
    scenario = load_scenario(spec.scenario, overrides=spec.overrides, duration_s=spec.duration_s)
    assert scenario.ticks > 0


def test_what_is_changed_arrives():
    spec = MATCHED_ON[2.0, 0.6]
    scenario = load_scenario(spec.scenario, overrides=spec.overrides)
    assert scenario.agent.flocking is not None
    assert scenario.agent.flocking.params.bandwidth_ratio == 0.05
    assert scenario.acoustics.outage.params.loss_prob == 0.6
    spec = separation_runs.RUNS["fuzzy", "plant + 30 %"]
    scenario = load_scenario(spec.scenario, overrides=spec.overrides)
    hulls = [vehicle.model.params for vehicle in scenario.vehicles]
    assert [hull.mass_kg for hull in hulls] == [162.5] * 4
    assert hulls[3].quadratic_damping[3] == 104.0
    assert hulls[0].max_wrench[0] == 150.0


def test_the_numbers_of_the_comparison_are_of_the_settled_flock():
    spec = RunSpec("ch6_four_leaders", FUZZY_FOUR_LEADERS.overrides, 105.0)
    scenario = load_scenario(spec.scenario, overrides=spec.overrides, duration_s=spec.duration_s)
    recording = run_in_process(scenario)
    metrics = compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)
    recording.command[:] = 3.0
    numbers = separation_laws.distance_numbers(Run(spec, scenario, recording, metrics))
    assert numbers["rms_m"] == pytest.approx(0.041, abs=1e-3)
    assert numbers["worst_m"] == pytest.approx(0.041, abs=1e-3)
    assert numbers["effort_n"] == pytest.approx(3.0 * 3.0**0.5)
    assert numbers["smallest_m"] == metrics["pair_distance_min_m"]


def test_a_wider_band_is_reached_no_later():
    spec = RunSpec("ch5_four_leaders", ("dt_s=0.02", "period_s=0.1"), 60.0)
    scenario = load_scenario(spec.scenario, overrides=spec.overrides, duration_s=spec.duration_s)
    run = Run(spec, scenario, run_in_process(scenario), {})
    times_s = [ch5_claims.reached_s(run, band) for band in (0.02, 0.05, 0.1, 0.2)]
    assert times_s[0] == pytest.approx(3.9, abs=0.05)
    assert times_s == sorted(times_s, reverse=True)
