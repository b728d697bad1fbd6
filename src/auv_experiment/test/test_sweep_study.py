"""Claims about studies: what they expand to, and that a wrong one is refused before anything runs."""

import itertools
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from auv_core.params import ConfigError, dump
from auv_experiment.scenario.loading import load_scenario, scenario_from_json, scenario_to_json
from auv_experiment.sweeps import cli
from auv_experiment.sweeps.plan import override_texts, plan_runs, points
from auv_experiment.sweeps.study import Distribution, list_studies, load_study, study_from_plain

WORDS = st.text(st.characters(categories=["L", "N", "P", "S"]), max_size=4)
LOSS, SLOT = "acoustics.outage.params.loss_prob", "acoustics.mac.params.slot_s"
TINY = {
    "schema": 1,
    "name": "tiny",
    "title": "Tiny",
    "scenario": "flock_modem",
    "duration_s": 2.0,
    "grid": {SLOT: [0.5, 1.0], LOSS: [0.0, 0.3, 0.6]},
    "seeds": [3, 1],
}


def study(**changes):
    return study_from_plain({**TINY, **changes})


def sampled(count, seed=1, **parameters):
    return study(grid=None, sample={"count": count, "seed": seed, "parameters": parameters})


def test_a_grid_is_all_combinations_with_all_seeds_the_last_parameter_fastest():
    runs = plan_runs(study())
    found = [(run.parameters[SLOT], run.parameters[LOSS], run.seed) for run in runs]
    assert found == list(itertools.product((0.5, 1.0), (0.0, 0.3, 0.6), (3, 1)))
    assert [run.index for run in runs] == list(range(12))
    assert len({run.key for run in runs}) == 12


def test_a_planned_run_is_the_scenario_that_the_same_overrides_give():
    run = plan_runs(study())[-1]
    overrides = [f"{SLOT}=1.0", f"{LOSS}=0.6"]
    expected = load_scenario("flock_modem", overrides=overrides, seed=1, duration_s=2.0)
    assert scenario_from_json(run.scenario_json) == expected


@pytest.mark.parametrize("name", ["flock_drift", "ch3_spiral", "ch4_region"])
def test_a_scenario_comes_back_from_its_json(name):
    scenario = load_scenario(name)
    assert scenario_from_json(scenario_to_json(scenario)) == scenario


def test_without_parameters_a_study_is_one_point_with_many_seeds():
    runs = plan_runs(study(grid=None, seeds={"first": 7, "count": 3}))
    assert [(run.parameters, run.seed) for run in runs] == [({}, 7), ({}, 8), ({}, 9)]


def test_a_grid_and_a_sample_are_multiplied():
    both = study(sample={"count": 4, "parameters": {"dt_s": {"choice": [0.1, 0.2]}}})
    assert len(list(points(both))) == both.n_runs / 2 == 24


@given(count=st.integers(1, 40), seed=st.integers(0, 2**31 - 1))
def test_a_sample_has_one_point_in_each_share_of_every_parameter(count, seed):
    drawn = list(
        points(sampled(count, seed, dt_s={"uniform": [2.0, 4.0]}, period_s={"log_uniform": [0.1, 10.0]}))
    )
    shares = [sorted(math.floor((p["dt_s"] - 2.0) / 2.0 * count) for p in drawn)]
    shares.append(sorted(math.floor(math.log10(p["period_s"] / 0.1) / 2.0 * count + 1e-9) for p in drawn))
    assert shares == [list(range(count))] * 2


def test_a_sample_is_the_same_every_time_and_another_with_another_seed():
    first, again, other = (list(points(sampled(9, seed, a={"uniform": [0, 1]}))) for seed in (1, 1, 2))
    assert first == again != other


@given(share=st.floats(0.0, 1.0, exclude_max=True), low=st.floats(1e-3, 1e3), width=st.floats(1e-3, 1e3))
def test_what_is_drawn_lies_in_its_bounds(share, low, width):
    uniform, log = (Distribution(**{kind: (low, low + width)}) for kind in ("uniform", "log_uniform"))
    for drawn in (uniform.at(share), log.at(share)):
        assert low <= drawn <= (low + width) * (1.0 + 1e-12)


def test_whole_numbers_and_choices_are_equally_likely():
    shares = (np.arange(600) + 0.5) / 600
    dice = [Distribution(integers=(1, 6)).at(share) for share in shares]
    assert [dice.count(n) for n in range(1, 7)] == [100] * 6
    words = [Distribution(choice=("a", None, [1])).at(share) for share in shares]
    assert [words.count(word) for word in ("a", None, [1])] == [200] * 3


@given(
    value=st.recursive(
        st.none()
        | st.booleans()
        | st.integers(-9, 9)
        | st.floats(allow_nan=False, allow_infinity=False)
        | WORDS,
        lambda inner: st.lists(inner, max_size=2) | st.dictionaries(WORDS, inner, max_size=2),
        max_leaves=4,
    )
)
def test_a_value_comes_back_from_its_override(value):
    from auv_experiment.scenario.file import override

    raw: dict[Any, Any] = {}
    (text,) = override_texts(study(duration_s=None), {"agent": value})
    override(raw, text)
    assert raw == {"agent": value}


def test_a_study_comes_back_from_its_dump():
    first = study(
        sample={"count": 2, "parameters": {"dt_s": {"choice": [0.1, 0.2]}}}, overrides={"title": "x"}
    )
    assert study_from_plain(dump(first)) == first


WRONG: dict[str, dict[str, Any]] = {
    "study: unknown key 'gird'": {"gird": {}},
    "study.seeds: missing": {"seeds": ...},
    "study.seeds: [] is not allowed": {"seeds": []},
    "study.seeds: 1 is given twice": {"seeds": [1, 1]},
    "study.seeds[0]: -1 is not allowed": {"seeds": [-1]},
    "study.seeds.count: 0 is not allowed": {"seeds": {"count": 0}},
    "study.seeds: unknown key 'last'": {"seeds": {"count": 1, "last": 3}},
    "study.seeds: 600000 runs are not allowed": {"seeds": {"count": 100_000}},
    "study.name: 'A b' is not allowed": {"name": "A b"},
    "study.grid: [1] is not allowed": {"grid": [1]},
    f"study.grid.{LOSS}: 0.3 is not allowed; allowed: a list": {"grid": {LOSS: 0.3}},
    f"study.grid.{LOSS}: nan is not allowed": {"grid": {LOSS: [math.nan]}},
    "study.grid.seed: not allowed; allowed: seeds under": {"grid": {"seed": [1]}},
    "study.grid.duration_s: is given twice": {"grid": {"duration_s": [1.0]}},
    "study.x: 'dt_s' is not allowed; allowed: acoustics": {"x": "dt_s"},
    f"study.by: '{LOSS}' is not allowed; allowed: {SLOT}": {"x": LOSS, "by": LOSS},
    "study.sample.parameters.dt_s.uniform: [0.2, 0.1] is not allowed": {
        "sample": {"count": 1, "parameters": {"dt_s": {"uniform": [0.2, 0.1]}}}
    },
    "study.sample.parameters.dt_s.choice: allowed: exactly one": {
        "sample": {"count": 1, "parameters": {"dt_s": {"uniform": [0.1, 0.2], "choice": [1]}}}
    },
    "study.sample.parameters.dt_s.log_uniform[0]: 0.0 is not allowed; allowed: a finite number above 0": {
        "sample": {"count": 1, "parameters": {"dt_s": {"log_uniform": [0.0, 0.2]}}}
    },
    "study.labels: 'dt_s' is not allowed; allowed: ": {"labels": {"dt_s": "step"}},
    "study.labels: 'no.path' is not allowed; allowed: ": {"labels": {"no.path": "words"}},
    f"study.labels.{LOSS}.values: 1 labels are not allowed; allowed: one for each of the 3 values": {
        "labels": {LOSS: {"values": ["none"]}}
    },
    "study.metrics: 'no_such_m' is not allowed; allowed: ": {"metrics": ["no_such_m"]},
    "study.metrics: 'real_time_factor' is not allowed": {"metrics": ["real_time_factor"]},
    f"study at {SLOT} = 0.5, {LOSS} = 1.5: scenario.{LOSS}: 1.5 is not allowed": {
        "grid": {SLOT: [0.5], LOSS: [0.0, 1.5]}
    },
    "study at no.such = 1: scenario: unknown key 'no'": {"grid": {"no.such": [1]}},
    "study at agent.separation.kind = \"gone\": scenario.agent.separation.kind: 'gone'": {
        "grid": {"agent.separation.kind": ["mathematical", "gone"]}
    },
}


@pytest.mark.parametrize("words", WRONG)
def test_a_wrong_study_is_refused_in_one_line_and_nothing_is_started(words, tmp_path, capsys):
    raw = {key: value for key, value in {**TINY, **WRONG[words]}.items() if value is not ...}
    path = tmp_path / "wrong.yaml"
    path.write_text(yaml.safe_dump(raw))
    assert cli.main([str(path), "--out", str(tmp_path / "out")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"error: {words}")
    assert not (tmp_path / "out").exists()


def test_metrics_of_laws_are_known_though_no_list_has_them():
    assert plan_runs(study(metrics=["consensus_rho_mps"], seeds=[1]))


@pytest.mark.parametrize("arguments", [[], ["no_such"], ["quick", "--workers", "0"], ["quick", "--no-such"]])
def test_wrong_arguments_are_refused_in_one_line(arguments, capsys):
    status: Any
    try:
        status = cli.main(arguments)
    except SystemExit as end:
        status = end.code
    assert status == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_the_scenario_of_a_study_is_seen_from_the_study(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump({**TINY, "scenario": "../a.yaml"}))
    assert load_study(str(path)).scenario == str(tmp_path / "../a.yaml")


@pytest.mark.parametrize("name", [name for name, _ in list_studies()])
def test_the_built_in_studies_are_allowed(name):
    shipped = load_study(name)
    assert shipped.name == name
    few = study_from_plain({**dump(shipped), "seeds": dump(shipped)["seeds"][:1]})
    assert len(plan_runs(few)) == few.n_runs


def test_the_study_of_the_documentation_is_allowed():
    text = (Path(__file__).parents[3] / "docs/how_to/sweeps.md").read_text(encoding="utf-8")
    shown, sample, _ = re.findall(r"```yaml\n(.*?)```", text, re.DOTALL)
    grid = study_from_plain({**yaml.safe_load(shown), "seeds": [1]})
    assert len(plan_runs(grid)) == 9
    of_the_grid = dict.fromkeys(("grid", "x", "by", "labels"))
    drawn = study_from_plain({**yaml.safe_load(shown), **yaml.safe_load(sample), **of_the_grid, "seeds": [1]})
    assert drawn.n_runs == 200


def test_an_unknown_study_is_told_with_the_known_ones():
    with pytest.raises(
        ConfigError, match=r"study: 'no_such' is not allowed; allowed: modems, obstacles, quick, safety"
    ):
        load_study("no_such")
