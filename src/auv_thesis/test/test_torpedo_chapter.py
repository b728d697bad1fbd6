"""Claims about the chapter on torpedoes: cells fly what they say; what is beyond a limit is said first."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest

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
from auv_thesis.runs.store import resolve_run
from auv_thesis.torpedoes import cells as study
from auv_thesis.torpedoes.limits import Limit
from auv_thesis.torpedoes.safety import judge, rows
from auv_thesis.torpedoes.studies import CONTROLS, DISTANCES, LOSSES, STUDIES

GOOD = {
    "pair_distance_min_m": 6.2,
    "pair_distance_working_min_m": 6.0,
    "wreck_distance_min_m": 9.0,
    "coordination_error_after_700s_p95_m": 0.2,
    "cross_track_rms_m": 0.05,
    "cross_track_max_m": 0.4,
    "packets_per_minute_after_700s": 5.0,
    "fleet_formed_at_s": 400.0,
}
ALL_CELLS = [cell for cells in STUDIES for cell in cells]


def _runs(cells, per_cell=study.N_SEEDS, **first):
    """Return good runs of cells, of which the very first has other metrics."""
    nothing: Any = None
    found = [Run(spec, nothing, nothing, GOOD) for cell in cells for spec in cell.specs[:per_cell]]
    return [replace(found[0], metrics={**GOOD, **first}), *found[1:]]


@pytest.mark.parametrize("cells", STUDIES, ids=lambda cells: cells[0].scenario)
def test_a_cell_of_every_study_flies_what_it_says(cells):
    cell = cells[-1]
    scenario = resolve_run(cell.specs[-1]).scenario
    assert scenario.name == cell.scenario
    assert f"of {len(scenario.vehicles)}" in cell.name
    assert f"slots of {scenario.acoustics.mac.params.slot_s:g} s" in cell.name
    assert f"{100.0 * scenario.acoustics.outage.params.loss_prob:.0f} % lost" in cell.name
    failing = [v.fails_at_s for v in scenario.vehicles if v.fails_at_s is not None]
    assert len(failing) == (1 if cell.scenario in ("torpedo_lost", "torpedo_column_flat") else 0)


def test_cells_differ_and_have_the_seeds_of_the_study():
    assert len({cell.name for cell in ALL_CELLS}) == len(ALL_CELLS)
    specs = [spec for cell in ALL_CELLS for spec in cell.specs]
    assert len(set(specs)) == len(specs), "no run serves two cells"
    seeds = range(study.FIRST_SEED, study.FIRST_SEED + 50)
    assert {spec.overrides[0] for spec in specs} == {f"seed={seed}" for seed in seeds}


def test_a_first_look_flies_few_runs_of_every_study():
    (few,) = with_seeds(choose(chapters(), ["torpedoes"]), study.FIRST_LOOK_SEEDS)
    assert len(few.runs) <= 20
    assert all(claim.runs for claim in few.claims)
    (whole,) = with_seeds(choose(chapters(), ["torpedoes"]), study.N_SEEDS)
    assert set(whole.runs) == {spec for cell in ALL_CELLS for spec in cell.specs}


def test_currents_and_losses_fill_their_ranges():
    losing = LOSSES[0].per_seed
    assert losing is not None
    vehicles = [losing(index)[0] for index in range(study.N_SEEDS)]
    assert all(f"{{id: auv_{index % 5 + 1}, " in words for index, words in enumerate(vehicles))
    times_s = sorted(float(words.split("fails_at_s: ")[1].split("}")[0]) for words in vehicles)
    assert times_s[0] < 755.0
    assert times_s[-1] > 845.0
    assert max(b - a for a, b in pairwise(times_s)) < 6.0


def test_a_distance_under_its_limit_is_said_first():
    verdict = judge(DISTANCES, _runs(DISTANCES, pair_distance_min_m=4.2))
    assert verdict.holds == DOES_NOT_HOLD
    assert verdict.evidence.startswith(
        f"Not kept: {DISTANCES[0]}: distance under 5 m in 1 of 50 (0.05 to 11 %)"
    )
    assert "distance 4.2 m" in verdict.evidence
    table = rows(DISTANCES, _runs(DISTANCES, pair_distance_min_m=4.2))
    assert [row.verdict for row in table] == [DIFFERS, *[AGREES] * (len(DISTANCES) - 1)]


def test_few_runs_agree_in_part_and_cells_without_runs_are_not_flown():
    assert judge(DISTANCES, _runs(DISTANCES)).holds == HOLDS
    few = _runs(DISTANCES[:1], per_cell=2)
    assert judge(DISTANCES, few).holds == HOLDS_IN_PART
    assert f"2 of {50 * len(DISTANCES)} runs are flown" in judge(DISTANCES, few).evidence
    assert [row.verdict for row in rows(DISTANCES, few)][:2] == [AGREES_IN_PART, NO_NUMBER]


def test_a_control_that_does_not_fail_breaks_its_limit():
    assert judge(CONTROLS, _runs(CONTROLS)).holds == DOES_NOT_HOLD


def test_a_fleet_that_never_forms_is_beyond_its_limit_and_a_missing_distance_is_not():
    runs = _runs(DISTANCES[2:3], fleet_formed_at_s=None, pair_distance_min_m=None)
    assert Limit("fleet_formed_at_s", 620.0).count_beyond(runs) == 1
    assert Limit("pair_distance_min_m", 5.0).count_beyond(runs) == 0
    assert Limit("fleet_formed_at_s", 620.0).worst(runs) == "time to form infinite"


def test_limits_on_shares_and_unknown_metrics():
    runs = _runs(DISTANCES[:1], pair_distance_min_m=1.0)
    assert not Limit("pair_distance_min_m", 5.0).is_kept(runs, 50)
    assert Limit("pair_distance_min_m", 5.0, most=0.02).is_kept(runs, 50)
    assert not Limit("pair_distance_min_m", 5.0, most=0.019).is_kept(runs, 50)
    assert Limit("pair_distance_min_m", 5.0, least=0.02).is_kept(runs, 50)
    assert not Limit("pair_distance_min_m", 5.0, least=0.04).is_kept(runs, 50)
    assert Limit("pair_distance_min_m", 5.0, least=0.04).is_kept(runs, 60), "few runs exclude no share"
    assert Limit("pair_distance_min_m", 5.0, most=0.3).is_kept(runs[:2], 50)
    assert not Limit("pair_distance_min_m", 5.0).is_kept(runs[:2], 50)
    with pytest.raises(ValueError, match="key: 'speed' is not allowed; allowed: pair_distance_min_m"):
        Limit("speed", 1.0)
