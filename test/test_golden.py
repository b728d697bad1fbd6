"""
Claims: metrics of runs do not change unnoticed, and no modem receives while it transmits.

Each file of ``golden/`` is a run and the metrics that it gave, each with its tolerance and its origin.
`python -m pytest test/test_golden.py --regen` writes today's values and shows what has changed; a new file
needs its run, and its metrics with the value null.
"""

import json
from pathlib import Path

import pytest

from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.run import compute_metrics
from auv_experiment.recording import acoustic_log
from auv_experiment.scenario.loading import load_scenario
from auv_sim.acoustics.event_log import half_duplex_violations

GOLDEN = sorted((Path(__file__).parent / "golden").glob("*.json"))


def _measured(golden):
    run = golden["run"]
    scenario = load_scenario(
        run["scenario"], overrides=run["overrides"], seed=run["seed"], duration_s=run["duration_s"]
    )
    recording = run_in_process(scenario)
    assert half_duplex_violations(acoustic_log(recording)) == []
    return compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)


def _differences(golden, metrics):
    """Return a line for every metric that has changed."""
    lines = []
    for key, expected in golden["metrics"].items():
        now, was = metrics[key], expected["value"]
        if was is None or now is None or isinstance(was, bool):
            same = now is was
        else:
            same = now == pytest.approx(was, rel=expected["rtol"], abs=0.0)
        if not same:
            lines.append(f"{key}: was {was!r}, is {now!r} (rtol {expected['rtol']:g}; {expected['origin']})")
    return lines


@pytest.mark.parametrize("path", GOLDEN, ids=lambda path: path.stem)
def test_a_run_amounts_to_what_it_did(path, request):
    golden = json.loads(path.read_text(encoding="utf-8"))
    metrics = _measured(golden)
    differences = _differences(golden, metrics)
    if request.config.getoption("--regen", default=False) and differences:
        for key, expected in golden["metrics"].items():
            expected["value"] = metrics[key]
        path.write_text(json.dumps(golden, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
        pytest.fail(f"{path.name} was written again; say why in the commit:\n" + "\n".join(differences))
    assert not differences, "\n".join(differences)


@pytest.mark.parametrize("path", GOLDEN, ids=lambda path: path.stem)
def test_every_golden_value_says_its_tolerance_and_its_origin(path):
    golden = json.loads(path.read_text(encoding="utf-8"))
    assert golden["metrics"]
    for key, expected in golden["metrics"].items():
        assert set(expected) == {"value", "rtol", "origin"}, key
        assert expected["value"] is not None, key
        assert 0.0 <= expected["rtol"] <= 0.05, key
        assert len(expected["origin"]) > 10, key


def test_there_are_golden_runs():
    assert len(GOLDEN) >= 5
