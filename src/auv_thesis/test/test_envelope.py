"""Claims about the safety envelope: what a cell says of itself is so, and what is not safe is said first."""

import io
from dataclasses import replace
from itertools import groupby
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure as Canvas

from auv_core.cli.tally import Tally
from auv_core.messages import Outcome
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.recording import acoustic_log
from auv_experiment.scenario.loading import load_scenario
from auv_sim.acoustics.outage.gilbert_elliott import Outage
from auv_thesis.acoustics.safety_runs import fleet
from auv_thesis.items import (
    AGREES,
    AGREES_IN_PART,
    DIFFERS,
    DOES_NOT_HOLD,
    HOLDS,
    HOLDS_IN_PART,
    NO_NUMBER,
    Run,
    chapters,
    choose,
    with_seeds,
)
from auv_thesis.laws import envelope
from auv_thesis.laws import envelope_runs as study
from auv_thesis.runs.runner import fly_all
from auv_thesis.runs.store import Store, resolve_run

GOOD = {
    "pair_distance_min_m": 1.5,
    "pair_distance_max_after_200s_m": 4.0,
    "pair_distance_formed_max_m": 5.0,
    "formed_at_s": 90.0,
}
TOUCHES = {**GOOD, "pair_distance_min_m": 0.5}
BURSTS = [cell for cell in study.CELLS if cell.wanted_burst_s is not None]


def _run(spec, metrics) -> Run:
    nothing: Any = None
    return Run(spec, nothing, nothing, metrics)


def _runs(per_cell=study.N_SEEDS, bad=None, metrics=TOUCHES, count=1):
    """Return good runs of all cells; of the cell `bad` the first `count` have other metrics."""
    return [
        _run(spec, metrics if cell == bad and index < count else GOOD)
        for cell, specs in study.STUDY.items()
        for index, spec in enumerate(specs[:per_cell])
    ]


@pytest.mark.parametrize("cell", BURSTS, ids=str)
def test_bursts_are_as_long_as_the_cell_says(cell):
    params = resolve_run(study.STUDY[cell][0]).scenario.acoustics.outage.params
    outage = Outage(params, study.FIRST_SEED)
    states = [outage.is_bad(1, 2, sequence) for sequence in range(1, round(1000 / cell.change_prob))]
    lengths = [len(list(group)) for is_bad, group in groupby(states) if is_bad]
    assert np.mean(lengths) * cell.cycle_s == pytest.approx(cell.burst_s, rel=0.1)
    assert np.mean(states) == pytest.approx(0.5, abs=0.06)
    assert cell.burst_s == pytest.approx(max(cell.wanted_burst_s, 2.0 * cell.cycle_s))
    assert f"bursts of {cell.burst_s:.0f} s" in str(cell)


@pytest.mark.parametrize("cell", [study.Cell(12, 0.5, 20.0), study.WORST], ids=str)
def test_every_vehicle_sends_one_packet_per_cycle(cell):
    spec = replace(study.STUDY[cell][0], duration_s=6.0 * cell.cycle_s)
    recording = run_in_process(resolve_run(spec).scenario)
    sent = [event for event in acoustic_log(recording) if event.outcome is Outcome.SENT]
    for address in range(1, cell.n_vehicles + 1):
        own = [event for event in sent if event.source == address]
        assert [event.sequence for event in own] == list(range(own[0].sequence, own[0].sequence + len(own)))
        assert len(own) in (5, 6)
        assert np.diff([event.start_s for event in own]) == pytest.approx(cell.cycle_s)


def test_cells_differ_and_have_the_wanted_starts():
    assert len({str(cell) for cell in study.CELLS}) == len(study.CELLS)
    radii = {}
    for cell, specs in study.STUDY.items():
        starts = resolve_run(specs[0]).scenario.random_starts
        assert starts is not None
        radii[cell] = starts.radius_m
    for cell, radius_m in radii.items():
        assert radius_m == pytest.approx(
            cell.start_radius_m or 10.0 * (cell.n_vehicles / 4.0) ** (1.0 / 3.0), abs=0.06
        )
    assert radii[study.Cell(4, 2.0, start_radius_m=study.WIDE_M)] == 40.0


def test_every_cell_flies_fresh_seeds_and_a_first_look_flies_few():
    tuned = {*range(3001, 3101), *range(4001, 4101), *range(7001, 7061), *range(8001, 8401)}
    seeds = {int(study.seed_of(_run(spec, GOOD))[5:]) for specs in study.STUDY.values() for spec in specs}
    assert min(seeds) == study.FIRST_SEED
    assert not seeds & tuned
    (whole,) = with_seeds(choose(chapters(), ["envelope"]), study.N_SEEDS)
    assert len(whole.runs) == sum(study.N_SEEDS * cell.runs_per_seed for cell in study.CELLS)
    (few,) = with_seeds((whole,), study.FIRST_LOOK_SEEDS)
    assert set(few.runs) == {
        spec for cell in study.FIRST_LOOK for spec in study.STUDY[cell] if spec.nth < study.FIRST_LOOK_SEEDS
    }
    (third,) = with_seeds((whole,), study.FIRST_LOOK_SEEDS + 1)
    assert {specs[0] for specs in study.STUDY.values()} <= set(third.runs)


def test_a_contact_is_said_first():
    bad = study.Cell(12, 2.0)
    verdict = envelope.CLAIMS[0].judge(_runs(bad=bad))
    assert verdict.holds == DOES_NOT_HOLD
    assert verdict.evidence.startswith(f"Not safe: hulls touch with {bad}: 1 of 100 (0.025 to 5.5 %).")
    rows = envelope.TABLES[0].rows(_runs(bad=bad))
    assert [row.verdict for row in rows] == [DIFFERS if cell == bad else AGREES for cell in study.CELLS]


def test_contacts_are_pooled_as_independent_runs_and_by_seed():
    n_runs = len(_runs())
    assert f"in runs none of {n_runs} (under " in envelope.pooled_words(_runs())
    assert "in seeds, which all cells share, none of 100 (under 3 %)" in envelope.pooled_words(_runs())
    twice = [
        _run(run.spec, TOUCHES if study.seed_of(run) == f"seed={study.FIRST_SEED}" else GOOD)
        for run in _runs()
    ]
    words = envelope.pooled_words(twice)
    assert f"in runs {len(study.CELLS)} of {n_runs} (" in words
    assert "in seeds, which all cells share, 1 of 100 (0.025 to 5.5 %)" in words


def test_runs_without_contact_that_are_few_are_not_called_safe():
    few = _runs(per_cell=58)
    verdict = envelope.CLAIMS[0].judge(few)
    assert verdict.holds == HOLDS_IN_PART
    assert verdict.evidence.startswith("Not shown to be safe")
    assert envelope.COMMAND in verdict.evidence
    assert {row.verdict for row in envelope.TABLES[0].rows(few)} == {AGREES_IN_PART}
    assert envelope.CLAIMS[0].judge(_runs(per_cell=59)).evidence.startswith("Hulls touch in no run.")


def test_the_whole_envelope_without_failures_holds():
    whole = [_run(spec, GOOD) for specs in study.STUDY.values() for spec in specs]
    assert [claim.judge(whole).holds for claim in envelope.CLAIMS] == [HOLDS, HOLDS]
    assert "few" not in envelope.CLAIMS[0].judge(whole).evidence


def test_cells_that_were_not_flown_are_counted():
    runs = [_run(study.STUDY[cell][0], GOOD) for cell in study.FIRST_LOOK]
    verdict = envelope.CLAIMS[0].judge(runs)
    assert verdict.holds == HOLDS_IN_PART
    missing = len(study.CELLS) - len(study.FIRST_LOOK)
    assert f"and {missing} of {len(study.CELLS)} cells not at all" in verdict.evidence
    rows = envelope.TABLES[0].rows(runs)
    assert sum(row.verdict == NO_NUMBER for row in rows) == missing


@pytest.mark.parametrize(
    ("cell", "metrics", "is_apart"),
    [
        (study.Cell(12, 2.0), {"pair_distance_max_after_200s_m": 11.0}, True),
        (study.Cell(12, 2.0), {"pair_distance_formed_max_m": 11.0}, False),
        (study.WORST, {"pair_distance_max_after_200s_m": 11.0}, False),
        (study.WORST, {"pair_distance_formed_max_m": 11.0}, True),
        (study.WORST, {"pair_distance_formed_max_m": None, "formed_at_s": None}, True),
    ],
)
def test_a_flock_is_apart_after_200_s_or_once_formed(cell, metrics, is_apart):
    def judged(count):
        runs = _runs(bad=cell, metrics={**GOOD, **metrics}, count=count)
        (summary,) = [s for c, s in envelope.summaries_of(runs).items() if c == cell]
        return summary, envelope.together_words(envelope.summaries_of(runs))

    summary, words = judged(6)
    assert summary.n_apart == (6 if is_apart else 0)
    assert words.startswith(f"Apart with {cell}: 6 of 100 (") == is_apart
    assert judged(5)[0].is_kept


def test_counts_and_distances_of_a_cell():
    cell = study.Cell(8, 0.5)
    specs = study.STUDY[cell]
    metrics = [
        {**GOOD, "pair_distance_min_m": 0.5 + 0.1 * k, "formed_at_s": 50.0 + 10.0 * k} for k in range(20)
    ]
    runs = [_run(spec, numbers) for spec, numbers in zip(specs, metrics, strict=False)]
    summary = study.summary_of(cell, runs)
    assert (summary.n, summary.n_touching, summary.n_near) == (20, 2, 5)
    assert (summary.n_late_formed, summary.n_never_formed) == (4, 0)
    assert (summary.nearest_m, summary.nearest_p05_m) == (0.5, 0.5)
    assert "hulls touch in 2 of 20 (1.2 to 32 %)" in summary.shares


def test_a_second_call_flies_only_what_is_missing(tmp_path):
    short = [replace(spec, duration_s=1.0) for spec in study.STUDY[study.Cell(4, 2.0)][:3]]

    def call(specs):
        with Tally("runs", io.StringIO()) as tally:
            flown = fly_all(specs, Store(tmp_path), n_workers=1, tally=tally)
            return flown, {path.name: path.stat().st_mtime_ns for path in tmp_path.iterdir()}

    first, before = call(short[:2])
    second, after = call(short)
    assert second.kept == {first.resolved[spec].key for spec in short[:2]}
    assert {key: after[key] for key in before} == before
    assert len(after) == 3


def test_the_figure_is_drawn_with_cells_missing():
    envelope.FIGURES[0].draw(Canvas(), [_run(study.STUDY[cell][0], GOOD) for cell in study.FIRST_LOOK])


def test_the_current_of_two_cells_varies():
    kinds = {
        cell: resolve_run(specs[0]).scenario.environment.current.kind for cell, specs in study.STUDY.items()
    }
    varying = [cell for cell, kind in kinds.items() if kind == "gauss_markov"]
    assert varying == [study.Cell(4, slot_s, is_current_varying=True) for slot_s in study.SLOTS_S]


def test_a_cell_is_flock_modem_but_for_what_it_names():
    plain = load_scenario("flock_modem", overrides=fleet(4), seed=study.FIRST_SEED)
    flown = resolve_run(study.STUDY[study.Cell(4, 2.0)][0]).scenario
    assert flown == plain
