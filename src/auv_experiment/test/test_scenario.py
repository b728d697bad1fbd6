"""Claims about scenarios: what is refused and how, presets, starts, round trips."""

import json
import math
from itertools import combinations

import pytest

from auv_core.geometry import distance
from auv_core.params import ConfigError
from auv_experiment.compose import agent_configs
from auv_experiment.scenario.file import SCENARIOS_DIR, read_raw
from auv_experiment.scenario.loading import list_scenarios, load_scenario, scenario_to_yaml
from auv_experiment.scenario.reach import water_speed_mps
from auv_sim.acoustics.propagation import bellhop

BUILT_IN = [name for name, _ in list_scenarios()]


def _refusal(name="flock_acoustic", **arguments):
    with pytest.raises(ConfigError) as refusal:
        load_scenario(name, **arguments)
    message = str(refusal.value)
    assert len(message.splitlines()) == 1
    return message


def _written(tmp_path, text):
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def _changed(tmp_path, **changes):
    """Return the path of the main job's scenario with other top-level keys (JSON is YAML)."""
    return _written(tmp_path, json.dumps({**read_raw(SCENARIOS_DIR / "flock_acoustic.yaml"), **changes}))


@pytest.mark.parametrize(
    ("preset", "law"),
    [
        ("ideal", "potential"),
        *((p, "communication_aware") for p in ("lossy", "fast", "micromodem_psk", "evologics_s2c")),
        ("micromodem_fdp", "communication_aware"),
    ],
)
def test_who_names_no_law_gets_the_one_for_his_modem(tmp_path, preset, law):
    agent = {"controller": {"kind": "velocity_pi"}}
    scenario = load_scenario(_changed(tmp_path, agent=agent, acoustics={"preset": preset}))
    assert scenario.agent.flocking is not None
    assert scenario.agent.flocking.kind == law
    assert (scenario.agent.hold_s > 0.0) == (law == "communication_aware")


def test_the_scenarios_of_the_thesis_and_the_main_job_are_built_in():
    wanted = {"flock_acoustic", "ch5_four_leaders", "ch5_one_leader", "ch5_one_leader_blind", "ch5_obstacles"}
    assert wanted <= set(BUILT_IN)


@pytest.mark.parametrize("name", BUILT_IN)
def test_every_built_in_scenario_loads_under_its_name_with_a_title(name):
    scenario = load_scenario(name)
    assert scenario.name == name
    assert scenario.title
    assert dict(list_scenarios())[name] == scenario.title


@pytest.mark.parametrize("name", BUILT_IN)
def test_the_resolved_scenario_loads_to_an_equal_one(name, tmp_path):
    scenario = load_scenario(name, seed=3)
    assert load_scenario(_written(tmp_path, scenario_to_yaml(scenario))) == scenario


@pytest.mark.parametrize(
    "title", ["1e3", "007", "yes", "null", "ein Fisch: größer", "#", "-", "", "'", "x" * 300]
)
def test_the_resolved_scenario_keeps_every_title(title, tmp_path):
    scenario = load_scenario(_changed(tmp_path, title=title))
    assert scenario.title == title
    assert load_scenario(_written(tmp_path, scenario_to_yaml(scenario))) == scenario


REFUSED_VALUES = [
    ("colour=1", ": unknown key 'colour'; allowed: [schema, name, title"),
    ("acoustics.outage.params.loss=0", ".acoustics.outage.params: unknown key 'loss'; allowed: [loss_prob]"),
    ("duration_s=soon", ".duration_s: 'soon' is not allowed; allowed: a finite number above 0"),
    ("vehicles=4", ".vehicles: 4 is not allowed; allowed: a list"),
    ("seed=1.5", ".seed: 1.5 is not allowed; allowed: a whole number"),
    ("seed=-1", ".seed: -1 is not allowed; allowed: a whole number at least 0 and at most 2147483647"),
    ("schema=2", ".schema: 2 is not allowed; allowed: a whole number at least 1 and at most 1"),
    (
        "acoustics.outage.params.loss_prob=2",
        ".acoustics.outage.params.loss_prob: 2.0 is not allowed; allowed",
    ),
    ("environment.current_ned_mps=[9, 0, 0]", ".environment.current_ned_mps[0]: 9.0 is not allowed"),
    ("dt_s=.nan", ".dt_s: nan is not allowed; allowed: a finite number"),
    ("vehicles.1.id=auv_1", ".vehicles[1].id: 'auv_1' is not allowed; allowed: an id that no other vehicle"),
    ("vehicles.1.id=AUV-2", ".vehicles[1].id: 'AUV-2' is not allowed; allowed: a lower-case letter"),
    ("leaders=[auv_9]", ".leaders[0]: 'auv_9' is not allowed; allowed: auv_1, auv_2, auv_3, auv_4"),
    ("leaders=[auv_1, auv_1]", ".leaders[1]: 'auv_1' is not allowed; allowed: an id that is no leader yet"),
    ("dt_s=0.03", ".period_s: 0.1 is not allowed; allowed: a whole multiple of dt_s = 0.03"),
    ("dt_s=1e-300", ".dt_s: 1e-300 is not allowed; allowed: a finite number at least 1e-05"),
    ("duration_s=0.25", ".duration_s: 0.25 is not allowed; allowed: a whole multiple of period_s = 0.1"),
    ("sampling=fast", ".sampling: 'fast' is not allowed; allowed: sampled, continuous"),
    ("sampling=continuous", ".sampling: 'continuous' is not allowed; allowed: sampled"),
    ("on_vehicle_loss=cry", ".on_vehicle_loss: 'cry' is not allowed; allowed: stop, continue"),
    ("name=../elsewhere", ".name: '../elsewhere' is not allowed; allowed: a lower-case letter"),
    ('title="two\\nlines"', ".title: 'two\\nlines' is not allowed; allowed: one line of text"),
    (
        "agent.flocking.kind=swarm",
        (
            ".agent.flocking.kind: 'swarm' is not allowed; "
            "allowed: bearing, communication_aware, displacement, potential"
        ),
    ),
    ("agent.controller.kind=velocity_direct", ".agent.controller.kind: 'velocity_direct' is not allowed"),
    (
        "vehicles.0.model.preset=boat",
        ".vehicles[0].model.preset: 'boat' is not allowed; allowed: bluerov2_heavy, ",
    ),
    ("acoustics.preset=air", ".acoustics.preset: 'air' is not allowed; allowed: "),
    (
        "random_starts=null",
        ".vehicles[0].position_ned_m: missing; allowed: a position here, or random_starts",
    ),
    ("random_starts.separation_m=50", ".random_starts: no room for 2 vehicles; allowed: a larger radius_m"),
    ("vehicles=[]", ".vehicles: 0 vehicles are not allowed; allowed: 1 to 254"),
    ("vehicles.0.position_ned_m=[0, 0, -1]", ".vehicles[0].position_ned_m: depth -1.0 m is not allowed"),
    ("vehicles.0.position_ned_m=[1e200, 0, 1]", ".vehicles[0].position_ned_m[0]: 1e+200 is not allowed"),
    ("vehicles.0.position_ned_m=[8, 5, 10]", ".environment.obstacles[0].position_ned_m: lies in the hull"),
    (
        "acoustics.mac.params.slot_s=0.05",
        ".acoustics.mac.params.slot_s: 0.05 is not allowed; allowed: longer",
    ),
    ("acoustics.modem.params.max_payload_bytes=9", ".acoustics.modem.params.max_payload_bytes: 9 is not"),
    ("reference.params.radius_m=1e200", ".reference.params.radius_m: 1e+200 is not allowed"),
]


@pytest.mark.parametrize(("override", "said"), REFUSED_VALUES)
def test_bad_values_are_refused_with_path_value_and_what_is_allowed(override, said):
    assert _refusal(overrides=[override]).startswith(f"scenario{said}")


def test_touching_vehicles_are_refused():
    overrides = ["vehicles.0.position_ned_m=[0, 0, 5]", "vehicles.1.position_ned_m=[0, 0.5, 5]"]
    message = _refusal(overrides=overrides)
    assert message.startswith(
        "scenario.vehicles[1].position_ned_m: touches vehicles[0]; allowed: more than 0.62"
    )


def test_starts_drawn_so_near_that_hulls_touch_are_refused():
    overrides = ["random_starts.separation_m=0.01", "random_starts.radius_m=0.3"]
    assert "touches vehicles[" in _refusal(overrides=overrides)


def test_layers_in_which_hulls_touch_are_refused():
    vehicles = ", ".join(f"{{id: auv_{k}, model: {{preset: odin}}}}" for k in range(1, 17))
    fleet = [f"vehicles=[{vehicles}]", "random_starts.radius_m=20.0"]
    with pytest.raises(ConfigError, match=r"16 layers within 7.5 m are not allowed; .* more than 9.3 m"):
        load_scenario("flock_modem", overrides=fleet)
    load_scenario("flock_modem", overrides=[*fleet, "agent.flocking.params.layer_span_m=9.4"])


def test_a_current_with_kinematic_vehicles_is_refused():
    message = _refusal("ch5_one_leader", overrides=["environment.current_ned_mps=[0.1, 0, 0]"])
    assert message.startswith("scenario.environment.current_ned_mps: a current is not allowed")


VARYING = "environment.current={kind: gauss_markov, params: {sd_ned_mps: [%s, 0, 0]}}"


def test_a_varying_current_is_refused_where_vehicles_or_time_do_not_allow_it():
    kinematic = _refusal("ch5_one_leader", overrides=[VARYING % 0.1, "sampling=sampled"])
    assert kinematic.startswith("scenario.environment.current.kind: 'gauss_markov' is not allowed")
    continuous = _refusal("ch3_circle", overrides=[VARYING % 0.1])
    assert continuous.endswith("allowed: sampled, unless environment.current is steady")


def test_a_current_counts_with_three_standard_deviations():
    held = load_scenario("flock_modem", overrides=[VARYING % 0.1])
    assert water_speed_mps(held) == pytest.approx(0.1 + 0.3)
    varying_mps, steady_mps = (
        agent_configs(scenario)[0].inputs.speed_max_mps or 0.0
        for scenario in (held, load_scenario("flock_modem"))
    )
    assert varying_mps - steady_mps == pytest.approx(3.0)
    message = _refusal("flock_modem", overrides=[VARYING % 1.0])
    assert message.startswith("scenario.environment.current: runs at 3.1 m/s, which is not allowed")


@pytest.mark.parametrize(
    "override",
    [
        "acoustics.preset=lossy",
        "acoustics.outage.kind=bernoulli",
        "agent.flocking.params.feedforward=flock",
        "agent.consensus.params.follow_flock=true",
        "agent.consensus={kind: pi, params: {follow_flock: false}}",
        "agent.consensus={kind: push_sum, params: {follow_flock: false}}",
        "agent.consensus={kind: neighbour_mean, params: {follow_flock: false}}",
    ],
)
def test_continuous_time_is_refused_for_what_lives_on_packets(override):
    assert _refusal("ch5_one_leader_blind", overrides=[override]).startswith(
        "scenario.sampling: 'continuous' is not allowed; allowed: sampled"
    )


@pytest.mark.parametrize("key", ["schema", "name", "title", "duration_s", "vehicles", "agent"])
def test_missing_keys_are_named(key, tmp_path):
    raw = read_raw(SCENARIOS_DIR / "flock_acoustic.yaml")
    del raw[key]
    assert _refusal(_written(tmp_path, json.dumps(raw))).startswith(f"scenario.{key}: missing; it is ")


@pytest.mark.parametrize("name", ["no_such", "Flock", "", "flock_acoustic\n", "..", "x" * 5000])
def test_unknown_names_are_refused_and_the_built_in_ones_named(name):
    message = _refusal(name)
    assert "is not allowed; allowed: ch2_pfapd, " in message
    assert message.endswith("or the path of a .yaml file")


@pytest.mark.parametrize("name", ["no/such.yaml", "/", "a\0b.yaml", "x" * 5000 + ".yaml", "new\nline.yaml"])
def test_files_that_cannot_be_read_are_refused(name):
    assert "cannot be read (" in _refusal(name)


def test_a_file_that_is_not_text_is_refused(tmp_path):
    path = tmp_path / "photo.yaml"
    path.write_bytes(b"\xff\xfe\x00\x81")
    assert "cannot be read (not UTF-8 text)" in _refusal(str(path))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "scenario: None is not allowed; allowed: a mapping of scenario keys"),
        ("- 1\n- 2", "scenario: [1, 2] is not allowed; allowed: a mapping of scenario keys"),
        ("a: [1", "scenario: not YAML: "),
        ("a: 1\na: 2", "scenario: not YAML: the key 'a' is given twice (line 1)"),
        ("a: *b", "scenario: not YAML: found undefined alias 'b' (line 1)"),
        ("a: !!python/object:os.system {}", "scenario: not YAML: could not determine a constructor"),
        ("? [1, 2]\n: 3", "scenario: not YAML: found unhashable key (line 1)"),
        ("a: \x07", "scenario: not YAML: "),
        ("a: !!int ''", "scenario: not YAML: a value that does not fit its type"),
        ("a: !!bool maybe", "scenario: not YAML: a value that does not fit its type"),
        ("a: !!timestamp now", "scenario: not YAML: a value that does not fit its type"),
        ("!!map [1, 2]", "scenario: not YAML: expected a mapping node"),
        ("a: 2001-99-99", "scenario: unknown key 'a'"),
        (f"a: {'9' * 5000}", "scenario: not YAML: a value that does not fit its type"),
        (f"a: 0x{'f' * 5000}", "scenario: unknown key 'a'"),
        (f"0x{'f' * 5000}", "scenario: '0xffff"),
        (f"? 0x{'f' * 5000}\n: 1", "scenario: unknown key '0xffff"),
        ("[" * 3000, "scenario: nested too deeply"),
    ],
)  # fmt: skip
def test_text_that_is_no_mapping_is_refused(text, said, tmp_path):
    assert _refusal(_written(tmp_path, text)).startswith(said)


def test_numbers_may_be_written_as_engineers_do(tmp_path):
    path = _written(
        tmp_path, scenario_to_yaml(load_scenario("flock_acoustic")).replace("dt_s: 0.02", "dt_s: 2e-2")
    )
    assert load_scenario(path).dt_s == 0.02


def test_a_preset_fills_what_is_left_out_and_explicit_values_win():
    plain = load_scenario("flock_acoustic")
    overrides = ["acoustics.outage.params.loss_prob=0.5", "vehicles.2.model.params.mass_kg=130"]
    changed = load_scenario("flock_acoustic", overrides=overrides)
    assert plain.acoustics.outage.params.loss_prob == 0.2
    assert changed.acoustics.outage.params.loss_prob == 0.5
    assert changed.acoustics.modem == plain.acoustics.modem
    assert [vehicle.model.params.mass_kg for vehicle in changed.vehicles] == [125.0, 125.0, 130.0, 125.0]
    assert changed.vehicles[2].model.params.added_mass == plain.vehicles[2].model.params.added_mass


def test_another_kind_than_the_presets_starts_from_its_own_defaults():
    changed = load_scenario("flock_acoustic", overrides=["acoustics.mac.kind=unlimited"])
    assert changed.acoustics.mac.kind == "unlimited"
    assert changed.acoustics.modem.kind == "fixed_rate"


def test_a_propagation_whose_solver_is_missing_names_the_command_that_brings_it(monkeypatch):
    monkeypatch.setattr(bellhop, "is_installed", lambda: False)
    with pytest.raises(ConfigError) as refused:
        load_scenario("range_sweep", overrides=["acoustics.propagation={kind: bellhop}"])
    assert str(refused.value).startswith(
        "scenario.acoustics.propagation.kind: 'bellhop' is not allowed, since"
    )
    assert str(refused.value).endswith("./scripts/setup --with bellhop")


def test_without_a_preset_every_section_must_be_there(tmp_path):
    message = _refusal(_changed(tmp_path, acoustics={"modem": {"kind": "ideal"}}))
    assert message.startswith("scenario.acoustics.propagation: missing")


def test_seed_and_duration_override_the_file():
    scenario = load_scenario("flock_acoustic", seed=9, duration_s=12.0)
    assert (scenario.seed, scenario.duration_s, scenario.ticks) == (9, 12.0, 120)
    assert scenario.medium_config.seed == 9


def starts_of(scenario):
    return [vehicle.position_ned_m for vehicle in scenario.vehicles]


@pytest.mark.parametrize("seed", range(1, 11))
def test_random_starts_keep_apart_below_the_surface_and_near_the_start_of_the_path(seed):
    scenario = load_scenario("flock_acoustic", seed=seed)
    starts = starts_of(scenario)
    assert all(distance(a, b) >= 3.0 for a, b in combinations(starts, 2))
    assert all(start[2] >= 1.0 for start in starts)
    path = scenario.reference_of()
    assert path is not None
    assert all(math.dist(start, path.at(0.0).position) <= 10.0 for start in starts)


def test_random_starts_lie_no_shallower_than_asked():
    overrides = ["random_starts.depth_min_m=11", "random_starts.separation_m=1"]
    for seed in range(5):
        scenario = load_scenario("flock_acoustic", overrides=overrides, seed=seed)
        assert all(start[2] >= 11.0 for start in starts_of(scenario))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_random_starts_in_order_are_the_same_places_the_highest_for_the_first_vehicle(seed):
    in_order, drawn = (
        [v.position_ned_m for v in load_scenario("flock_modem", seed=seed, overrides=overrides).vehicles]
        for overrides in ([], ["random_starts.in_depth_order=false"])
    )
    assert in_order == sorted(drawn, key=lambda position: position[2] if position else math.nan)
    assert len(set(in_order)) == 4


def test_random_starts_change_with_the_seed_and_only_with_it():
    def starts(seed):
        return starts_of(load_scenario("flock_acoustic", seed=seed))

    assert starts(1) == starts(1)
    assert not set(starts(1)) & set(starts(2))


def test_given_starts_stay_and_the_others_keep_clear_of_them():
    scenario = load_scenario("flock_acoustic", overrides=["vehicles.3.position_ned_m=[1, 9, 9]"])
    assert scenario.vehicles[3].position_ned_m == (1.0, 9.0, 9.0)
    assert all(distance(start, (1.0, 9.0, 9.0)) >= 3.0 for start in starts_of(scenario)[:3])


def test_tick_times_and_hull_and_kind_of_command_are_the_scenarios():
    scenario = load_scenario("flock_acoustic", duration_s=1.0)
    assert scenario.tick_times().tolist() == [k * 0.1 for k in range(11)]
    assert scenario.hull_radius_m == 0.31
    assert not scenario.kinematic
    assert load_scenario("ch5_obstacles").kinematic
