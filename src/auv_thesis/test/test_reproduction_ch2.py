"""Chapter 2 of the reproduction: its runs exist, verdicts follow from numbers, its items can be made."""

from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure as Canvas

from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.scenario.loading import load_scenario
from auv_thesis.ch2 import claims as ch2_claims
from auv_thesis.ch2 import claims_settling
from auv_thesis.ch2 import tables as ch2
from auv_thesis.ch2.figures import FIGURES
from auv_thesis.ch2.runs import APD, GAIN_RUNS, GAIN_SETS, MIXED, PD, PD_OBSTACLES, settling_s
from auv_thesis.items import AGREES, AGREES_IN_PART, DIFFERS, DOES_NOT_HOLD, HOLDS, HOLDS_IN_PART, Run

ITEMS = (*FIGURES, *ch2.TABLES, *ch2_claims.CLAIMS, *claims_settling.CLAIMS)
SPECS = tuple(dict.fromkeys(spec for item in ITEMS for spec in item.runs))


def _flown(spec):
    scenario = load_scenario(
        spec.scenario, overrides=(*spec.overrides, "dt_s=0.1"), duration_s=spec.duration_s
    )
    recording = run_in_process(scenario)
    metrics = compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)
    return Run(spec, scenario, recording, metrics)


@pytest.mark.parametrize("spec", SPECS, ids=str)
def test_runs_can_be_resolved(spec):
    scenario = load_scenario(spec.scenario, overrides=spec.overrides, duration_s=spec.duration_s)
    assert scenario.sampling == "continuous"


def test_every_figure_and_table_of_the_chapter_is_there():
    assert [figure.number for figure in FIGURES] == [f"2.{number}" for number in range(6, 19)]
    assert {"2.2", "2.A", "2.B", "2.C"} == {table.number for table in ch2.TABLES}


@pytest.mark.parametrize(
    ("thesis", "value_m", "verdict"),
    [
        ("0.3161", 0.31614, AGREES),
        ("0.3161", 0.3170, AGREES_IN_PART),
        ("0.2394", 0.2750, DIFFERS),
        ("-0.0202", -0.02019, AGREES),
        ("-0.001288", 0.0072, DIFFERS),
        ("10.00", 10.0, AGREES),
    ],
)
def test_a_reading_agrees_when_every_printed_digit_does(thesis, value_m, verdict):
    assert ch2._reading("x", thesis, value_m).verdict == verdict


@pytest.mark.parametrize(
    ("found_s", "verdict"),
    [
        ((10.9, 10.5, 10.0), AGREES),
        ((11.6, 10.5, 10.0), AGREES_IN_PART),
        ((None, 31.0, 10.5), AGREES_IN_PART),
        ((None, None, 31.0), DIFFERS),
        ((None, None, None), DIFFERS),
    ],
)
def test_a_settling_time_agrees_only_if_no_band_changes_it(found_s, verdict):
    assert ch2._time("x", 10.0, found_s, "").verdict == verdict


def test_an_error_settles_when_it_is_within_the_band_for_good():
    t_s, sizes = np.arange(6.0), np.array([3.0, 0.1, 2.0, 0.4, 0.2, 1.0])
    assert settling_s(t_s, sizes, 1.5) == 3.0
    assert settling_s(t_s, sizes, 1.0) is None
    assert settling_s(t_s, sizes, 1.0, until_s=5.0) == 3.0
    assert settling_s(t_s, sizes, 9.0) == 0.0


def test_the_printed_gains_do_not_hold_and_the_swapped_ones_do():
    verdict = ch2_claims._find_gains([_with_readings(gains) for gains in GAIN_SETS])
    assert verdict.holds == DOES_NOT_HOLD
    assert "every digit: [50 40 0]." in verdict.evidence


def _with_readings(gains):
    values = (0.31614, 0.0840, -0.02019) if gains == (50.0, 40.0) else (0.3170, 0.0856, -0.0204)
    return SimpleNamespace(metrics=dict(zip([key for key, _ in ch2_claims.PD_READINGS], values, strict=True)))


@pytest.mark.slow
def test_every_item_can_be_made_and_the_main_verdicts_stand():
    runs = {spec: _flown(spec) for spec in SPECS}
    verdicts = {}
    for claim in (*ch2_claims.CLAIMS, *claims_settling.CLAIMS):
        verdict = claim.judge([runs[spec] for spec in claim.runs])
        assert verdict.evidence
        verdicts[claim.text] = verdict.holds
    for table in ch2.TABLES:
        assert table.rows([runs[spec] for spec in table.runs])
    for figure in FIGURES:
        canvas = Canvas()
        figure.draw(canvas, [runs[spec] for spec in figure.runs])
        assert canvas.axes
    assert verdicts["Augmented PD performs better than PD."] == HOLDS
    assert verdicts["With PD the position errors converge to zero."] == DOES_NOT_HOLD
    assert verdicts["With augmented PD the position errors converge to zero."] == HOLDS_IN_PART
    assert verdicts["The velocity errors are zero after about 22 s, with either law."] == HOLDS_IN_PART
    assert verdicts["The runs have K_v = [40 50 0]."] == DOES_NOT_HOLD
    assert runs[MIXED].metrics["position_settling_0p1m_s"] is None
    assert len(GAIN_RUNS) == 9
    assert {PD, APD, PD_OBSTACLES} <= set(SPECS)
