"""Chapter 3 of the reproduction: verdicts follow from numbers, and its items can be made."""

from types import SimpleNamespace
from typing import Any

import pytest
from matplotlib.figure import Figure as Canvas

from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.scenario.loading import load_scenario
from auv_thesis.ch3 import claims as ch3_claims
from auv_thesis.ch3 import estimates
from auv_thesis.ch3 import tables as ch3_tables
from auv_thesis.ch3.figures import FIGURES
from auv_thesis.ch3.runs import CIRCLE, CROSSING, SPIRAL, WIND_UP, corrected_runs, printed_runs
from auv_thesis.items import AGREES, DOES_NOT_HOLD, HOLDS, HOLDS_IN_PART, Run

TABLES = (*ch3_tables.TABLES, *estimates.TABLES)
ITEMS = (*FIGURES, *TABLES, *ch3_claims.CLAIMS)
SPECS = tuple(dict.fromkeys(spec for item in ITEMS for spec in item.runs))


def _flown(spec, *changes, duration_s=None):
    scenario = load_scenario(
        spec.scenario, overrides=(*spec.overrides, *changes), duration_s=duration_s or spec.duration_s
    )
    recording = run_in_process(scenario)
    metrics = compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)
    return Run(spec, scenario, recording, metrics)


@pytest.fixture(scope="module")
def short():
    return {spec: _flown(spec, "dt_s=0.05", duration_s=30.0) for spec in (CIRCLE, SPIRAL)}


def test_every_figure_and_table_of_the_chapter_is_there():
    assert [figure.number for figure in FIGURES] == [f"3.{number}" for number in range(4, 15)]
    assert [table.number for table in TABLES] == ["3.1", "3.A", "3.B", "3.C", "3.D", "3.E", "3.F"]


@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: figure.number)
def test_figures_can_be_drawn(figure, short):
    canvas = Canvas()
    figure.draw(canvas, [short[spec] for spec in figure.runs])
    assert canvas.axes
    assert all(axes.get_xlabel() and axes.get_ylabel() for axes in canvas.axes)


def test_table_3_1_is_used_as_given(short):
    rows = ch3_tables._parameters([short[CIRCLE], short[CIRCLE]])
    assert [row.verdict for row in rows[:6]] == [AGREES] * 6
    assert rows[5].ours == "200, 10, 20, 0, 0, 0, 10, 10"


@pytest.mark.parametrize(
    ("values", "met"),
    [
        ((-0.52, 10.0), (True, True)),
        ((0.0, 10.0), (False, True)),
        ((-2.0, 8.0), (True, False)),
        ((-2.1, 10.1), (False, False)),
    ],
)
def test_an_axis_ends_at_the_next_tick(values, met):
    assert ch3_tables.fits(values, (-2.0, 10.0, 2.0)) == met


def test_the_axes_of_the_start_agree_but_for_the_force_of_the_spiral(short):
    rows = ch3_tables._axes([short[CIRCLE], short[SPIRAL]])
    assert {row.quantity[:4] for row in rows if row.verdict != AGREES} == {"3.12"}


@pytest.mark.parametrize(
    ("late_n", "holds"), [((0.0, 0.0, 0.0), HOLDS), ((3.23, 4.06, 237.0), DOES_NOT_HOLD)]
)
def test_forces_that_stay_are_told(late_n, holds):
    metrics = dict(zip(("x_force_late_n", "y_force_late_n", "z_force_late_n"), late_n, strict=True))
    run: Any = SimpleNamespace(metrics=metrics)
    assert ch3_claims._forces_vanish([run, run]).holds == holds


@pytest.mark.parametrize(("high_n", "holds"), [(37000.0, HOLDS), (4100.0, DOES_NOT_HOLD)])
def test_the_force_of_the_spiral_is_judged_by_its_axis(high_n, holds):
    run: Any = SimpleNamespace(metrics={"force_range_n": [-100.0, high_n]})
    assert ch3_claims._spiral_force([run]).holds == holds


@pytest.mark.parametrize(
    ("printed", "corrected", "holds"),
    [(True, True, HOLDS), (False, True, HOLDS_IN_PART), (False, False, DOES_NOT_HOLD)],
)
def test_stability_is_judged_by_both_candidates(printed, corrected, holds):
    first = {
        "lyapunov_thesis_falls": printed,
        "lyapunov_thesis_rise_ratio": 0.1,
        "lyapunov_thesis_first_rise_s": 8.6,
        "lyapunov_proof_gap": "why",
    }
    second = {"lyapunov_corrected_falls": corrected, "lyapunov_thesis_rise_ratio": 0.8}
    runs: list[Any] = [SimpleNamespace(metrics=first), SimpleNamespace(metrics=second)]
    assert ch3_claims._stable_by_lyapunov(runs).holds == holds


def test_vehicles_that_cross_collide():
    verdict = ch3_claims._collisions_avoided([_flown(CROSSING, "dt_s=0.05", duration_s=10.0)])
    assert verdict.holds == DOES_NOT_HOLD


def test_a_negative_mass_is_no_estimate():
    verdict = ch3_claims._estimates_mean_something([_flown(WIND_UP[1])])
    assert verdict.holds == DOES_NOT_HOLD
    assert "-16.2 kg" in verdict.evidence


def test_the_studies_ask_for_each_run_once():
    assert len(set(printed_runs(0.7))) == 5
    assert len(set(corrected_runs("circle", 30.0, 0.05, "fixed"))) == 6


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_every_item_can_be_made_and_the_main_verdicts_stand():
    runs = {spec: _flown(spec) for spec in SPECS}
    verdicts = {}
    for claim in ch3_claims.CLAIMS:
        verdict = claim.judge([runs[spec] for spec in claim.runs])
        assert verdict.evidence
        verdicts[claim.text] = verdict.holds
    for table in TABLES:
        assert table.rows([runs[spec] for spec in table.runs])
    assert verdicts["Adaptation compensates for unknown hydrodynamics."] == DOES_NOT_HOLD
    assert verdicts["The law is stable, since V of (3.21) decreases."] == HOLDS_IN_PART
    assert verdicts["AUV1 and AUV2, AUV2 and AUV3 stay 10 m apart, circle."] == HOLDS
