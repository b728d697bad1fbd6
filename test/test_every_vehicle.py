"""
Claim: every vehicle, whether it can stop or not, passes the checks of a scenario, flies, and gets metrics, a
report and figures.

The vehicles are the presets of the plugin folder and, with the folder of this test's plugins, a kind without
forces that cannot stop: an assumption that only hovering hulls meet fails here by the name of the vehicle.
"""

import json
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

import auv_core.models
from auv_core.models import make_model
from auv_core.params import ConfigError, load_section
from auv_core.plugins import find_plugin
from auv_experiment.figures.by_law import run_drawers
from auv_experiment.figures.files import save_figures
from auv_experiment.inprocess.sampled import run_in_process
from auv_experiment.metrics.descriptions import MEANINGS, family_meaning
from auv_experiment.metrics.run import compute_metrics, metrics_to_json
from auv_experiment.report.verdicts import verdicts
from auv_experiment.scenario.loading import load_scenario

MODELS = Path(auv_core.models.__file__).parent
PLUGINS = Path(__file__).parent / "plugins"
VEHICLES = {path.stem: {"preset": path.stem} for path in sorted((MODELS / "presets").glob("*.yaml"))}
VEHICLES["dart"] = {"kind": "dart"}
TASKS = {
    "wrench": {"controller": {"kind": "velocity_pi"}},
    "thrusters": {"controller": {"preset": "velocity_pi_bluerov2_heavy"}},
    "velocity": {"controller": {"kind": "velocity_direct"}},
    "fins": {"controller": {"kind": "autopilot"}, "course": {"kind": "steps"}},
}
DURATION_S = 1.0


@pytest.fixture(autouse=True)
def plugins(monkeypatch):
    """Add the models of the plugins, without their metrics and figures."""
    monkeypatch.setattr(auv_core.models, "__path__", [*auv_core.models.__path__, str(PLUGINS / "models")])


@cache
def model_of(name):
    section = VEHICLES[name]
    if "preset" in section:
        section = yaml.safe_load((MODELS / "presets" / f"{name}.yaml").read_text(encoding="utf-8"))
    return make_model(load_section(section, "model", "auv_core.models"))


def scenario_of(name, folder, **changes):
    """Return a scenario of two vehicles, 8 m apart, with the task for their command."""
    model = model_of(name)
    vehicle = {"model": VEHICLES[name], "speed_mps": 0.0 if model.handling.can_stop else 1.5}
    places = [[0.0, 10.0, 10.0], [8.0, 10.0, 10.0]]
    text = {
        "schema": 1,
        "name": "every_vehicle",
        "title": f"Two vehicles of the preset {name}",
        "duration_s": DURATION_S,
        "dt_s": 0.05,
        "period_s": 0.1,
        "vehicles": [
            {"id": f"auv_{number}", "position_ned_m": place, **vehicle}
            for number, place in enumerate(places, start=1)
        ],
        "agent": TASKS[model.command],
        "acoustics": {"preset": "ideal"},
        **({} if model.command == "fins" else {"reference": {"kind": "circle"}, "leaders": "all"}),
        **changes,
    }
    path = folder / "scenario.yaml"
    path.write_text(yaml.safe_dump(text), encoding="utf-8")
    return load_scenario(str(path))


@cache
def flown(name, folder):
    scenario = scenario_of(name, folder)
    recording = run_in_process(scenario)
    return scenario, recording, compute_metrics(recording, scenario, mode="inprocess", real_time_factor=1.0)


@pytest.fixture(params=VEHICLES)
def flight(request, tmp_path_factory):
    return flown(request.param, tmp_path_factory.mktemp("flown"))


def test_a_flight_has_metrics_that_are_described_and_say_nothing_bad(flight):
    scenario, recording, metrics = flight
    assert json.loads(metrics_to_json(metrics)) == metrics
    assert [key for key in metrics if key not in MEANINGS and not family_meaning(key)] == []
    assert (metrics["collision"], metrics["hull_in_air_ratio"], metrics["lost_vehicles"]) == (False, 0.0, [])
    assert metrics["safe_command_ratio"] == 0.0
    assert 2.0 * scenario.hull_radius_m + 1.0 < metrics["pair_distance_min_m"] < 8.5
    assert metrics.get("near_pairs", 0) == 0
    can_stop = scenario.handlings[0].can_stop
    assert ("fin_effort_rad2s" in metrics) == ("near_pairs" in metrics) == (not can_stop)
    assert np.isfinite(recording.actuator_output).all()


def test_its_report_answers_in_whole_sentences(flight):
    scenario, _, metrics = flight
    answers = verdicts(scenario, metrics)
    touch_m = f"hulls touch at {2.0 * scenario.hull_radius_m:g} m."
    assert any(touch_m in answer for answer in answers)
    assert not any(word in answer for answer in answers for word in ("nan", "None", "inf "))


@pytest.mark.slow
def test_all_its_figures_are_drawn(flight, tmp_path):
    scenario, recording, _ = flight
    saved = save_figures(run_drawers(recording, scenario), scenario, tmp_path)
    assert saved.failures == ()
    own = {"course_plan", "course_errors", "actuators"} if scenario.follows == "course" else {"plan", "speed"}
    assert {figure.path.stem for figure in saved.figures} >= own | {"pair_distances"}


@pytest.mark.parametrize("name", VEHICLES)
def test_a_vehicle_that_is_asked_to_wait_or_to_outrun_itself_is_refused_in_one_line(name, tmp_path):
    model = model_of(name)
    if not model.handling.can_stop:
        agent = {**TASKS[model.command], "hold_s": 5.0}
        with pytest.raises(ConfigError, match=r"^scenario\.agent\.hold_s: 5\.0 is not allowed; allowed: 0"):
            scenario_of(name, tmp_path, agent=agent)
    if math.isfinite(model.top_speed_mps) and model.command != "velocity":
        current = {"current_ned_mps": [0.0, min(5.0, 1.1 * model.top_speed_mps), 0.0]}
        with pytest.raises(ConfigError, match=r"^scenario\.(environment|vehicles|agent)[^\n]*allowed[^\n]*$"):
            scenario_of(name, tmp_path, environment=current)


@settings(max_examples=20, deadline=None)  # the first call flies the turns of a torpedo
@given(name=st.sampled_from(sorted(VEHICLES)), share=st.floats(0.0, 1.0), heading_rad=st.floats(-3.0, 3.0))
def test_a_start_speed_holds_for_a_moment_and_a_turn_has_a_radius(name, share, heading_rad):
    model = model_of(name)
    handling, top_mps = model.handling, min(model.top_speed_mps, 3.0)
    speed_mps = handling.least_speed_mps + share * (top_mps - handling.least_speed_mps)
    state = model.initial_state((0.0, 0.0, 50.0), heading_rad, speed_mps)
    after = model.step(state, model.limited_command(model.resting_command()), (0.0, 0.0, 0.0), 0.01)
    if model.command != "velocity":
        assert math.hypot(*after[7:10]) == pytest.approx(speed_mps, rel=0.1, abs=0.05)
    assert (model.turn_radius_m(speed_mps) == 0.0) == handling.can_stop


def test_fins_without_a_state_are_refused_in_one_line(monkeypatch):
    model_of.cache_clear()
    monkeypatch.setattr(find_plugin("auv_core.models", "dart").Model, "actuators", ())
    with pytest.raises(
        ConfigError,
        match=r"^auv_core\.models\.dart: 0 actuators are not allowed; allowed: one for each of the 3",
    ):
        model_of("dart")
