"""Claims about the composition root: the nodes get exactly what the one-process run gets."""

import dataclasses
import re
from pathlib import Path

import pytest
import yaml

from auv_bringup.launching.node_specs import node_specs
from auv_core.params import load
from auv_experiment.compose import agent_configs, vehicle_configs
from auv_experiment.scenario.loading import load_scenario
from auv_experiment.scenario.schema import Acoustics, Environment, Scenario, VehicleEntry
from auv_flocking.agent_config import AgentConfig, AgentSettings
from auv_ros.run_config import RunConfig
from auv_sim.acoustics.medium import MediumConfig
from auv_sim.vehicle import VehicleConfig

SCENARIOS = ["flock_acoustic", "ch5_obstacles"]
BAG = Path("results") / "bag"


def _specs(name="flock_acoustic", *, mode="lockstep", bag_dir=BAG, **arguments):
    scenario = load_scenario(name, **arguments)
    return scenario, node_specs(scenario, mode=mode, bag_dir=bag_dir)


def _with_role(specs, role):
    return [spec for spec in specs if spec.role == role]


def _config(cls, spec):
    """Load what a node gets into its configuration, and what all share into the run's."""
    names = {field.name for field in dataclasses.fields(cls)}
    return load(cls, {key: value for key, value in spec.params.items() if key in names}, spec.name)


@pytest.mark.parametrize("name", SCENARIOS)
def test_nodes_get_exactly_the_configurations_of_the_one_process_run(name):
    scenario, specs = _specs(name, seed=4)
    assert [_config(VehicleConfig, spec) for spec in _with_role(specs, "vehicle")] == vehicle_configs(
        scenario
    )
    assert [_config(AgentConfig, spec) for spec in _with_role(specs, "agent")] == agent_configs(scenario)
    (relay,) = _with_role(specs, "relay")
    assert _config(MediumConfig, relay) == scenario.medium_config


def test_the_filters_know_the_white_noise_of_the_navigation_that_the_fleet_carries():
    exact, noisy = (
        load_scenario("flock_modem", overrides=overrides)
        for overrides in (
            [],
            ["environment.navigation={kind: noisy, params: {position_sd_m: 0.08, velocity_sd_mps: 0.02}}"],
        )
    )
    assert agent_configs(exact)[0].neighbours == exact.agent.neighbours
    for config in agent_configs(noisy):
        assert config.neighbours.position_std_m == pytest.approx((0.08**2 + 0.006**2) ** 0.5)
        assert config.neighbours.velocity_std_mps == pytest.approx((0.02**2 + 0.0007**2) ** 0.5)


def test_a_vehicle_is_two_nodes_and_the_rest_are_two_more():
    scenario, specs = _specs()
    assert len(specs) == 2 * len(scenario.vehicles) + 2
    assert len({spec.name for spec in specs}) == len(specs)
    assert [spec.name for spec in specs[:3]] == [
        "/acoustic_relay_node",
        "/auv_1/vehicle_node",
        "/auv_1/agent_node",
    ]
    assert specs[-1].name == "/recorder_node"


def test_without_a_bag_there_is_no_recorder_and_nobody_waits_for_one():
    _, specs = _specs(bag_dir=None)
    assert not _with_role(specs, "recorder")
    assert not any(spec.params["recorded"] for spec in specs)


def test_the_recorder_knows_the_bag_and_the_vehicles():
    _, specs = _specs()
    (recorder,) = _with_role(specs, "recorder")
    assert recorder.params["bag_dir"] == str(BAG)
    assert recorder.params["topics_vehicles"] == ["auv_1", "auv_2", "auv_3", "auv_4"]
    assert recorder.params["commands"] == ["wrench"] * 4


@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
def test_all_nodes_keep_the_same_time(mode):
    _, specs = _specs(mode=mode)
    runs = {
        _config(RunConfig, spec) for spec in specs if spec.role != "recorder"
    }  # fmt: skip
    assert len(runs) == 1
    assert runs.pop() == RunConfig(mode=mode, recorded=True)


def test_only_the_named_leaders_lead():
    scenario = load_scenario("flock_acoustic", overrides=["leaders=[auv_2, auv_4]"])
    assert [config.is_leader for config in agent_configs(scenario)] == [False, True, False, True]


def test_addresses_are_places_in_the_list():
    assert [config.address for config in agent_configs(load_scenario("flock_acoustic"))] == [1, 2, 3, 4]


def test_only_where_the_run_goes_on_does_the_relay_know_the_hulls():
    _, specs = _specs()
    assert "hulls" not in specs[0].params
    scenario, specs = _specs(overrides=["on_vehicle_loss=continue"])
    hulls = specs[0].params["hulls"]
    assert [load(VehicleConfig, hulls[v.id], v.id) for v in scenario.vehicles] == vehicle_configs(scenario)


@pytest.mark.parametrize("name", SCENARIOS)
def test_parameters_are_plain_yaml_without_empty_values(name):
    _, specs = _specs(name, overrides=["on_vehicle_loss=continue"])
    for spec in specs:
        assert yaml.safe_load(yaml.safe_dump(spec.params)) == spec.params
        for value in _leaves(spec.params):
            assert value is not None
            assert value != []


@pytest.mark.parametrize("name", SCENARIOS)
def test_lists_are_of_one_type_as_ros_parameters_must_be(name):
    _, specs = _specs(name)
    lists = [value for spec in specs for value in _leaves(spec.params) if isinstance(value, list)]
    assert lists
    assert all(len({type(item) for item in value}) == 1 for value in lists)


def _leaves(value):
    if not isinstance(value, dict):
        return [value]
    return [leaf for item in value.values() for leaf in _leaves(item)]


@pytest.mark.parametrize("name", SCENARIOS)
def test_modules_and_executables_of_all_nodes_exist(name):
    _, specs = _specs(name)
    source = Path(__file__).parents[2]
    for spec in specs:
        package, *rest = spec.module.split(".")
        assert package == spec.package
        assert (source / package / package / Path(*rest).with_suffix(".py")).is_file()
        setup = (source / package / "setup.py").read_text()
        assert re.search(rf"\b{spec.executable} = {re.escape(spec.module)}:main\b", setup)


def test_a_value_of_a_scenario_and_of_a_configuration_is_described_once() -> None:
    """All but a start that may be drawn, and a path that a vehicle takes from its scenario."""
    own = {"position_ned_m", "reference"}
    sections = (AgentSettings, Acoustics, Environment, VehicleEntry, Scenario)
    for config in (AgentConfig, MediumConfig, VehicleConfig):
        known = {field.name: field for field in dataclasses.fields(config)}
        for field in (field for section in sections for field in dataclasses.fields(section)):
            if field.name in known.keys() - own:
                assert dict(known[field.name].metadata) == dict(field.metadata), field.name
                assert known[field.name].default == field.default, field.name
