"""Claims about layouts: the same nodes in fewer processes, and what a run cannot have is refused."""

from pathlib import Path

import pytest

from auv_bringup.launching.layout import DEFAULT_LAYOUT, LAYOUTS, check_layout, process_specs
from auv_bringup.launching.node_specs import node_specs
from auv_core.params import ConfigError
from auv_experiment.scenario.loading import load_scenario

NODES = node_specs(load_scenario("flock_acoustic"), mode="lockstep", bag_dir=Path("bag"))


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_layout_has_every_node_once(layout):
    found = [node for process in process_specs(NODES, layout) for node in process.nodes]
    assert sorted(found, key=str) == sorted(NODES, key=str)


@pytest.mark.parametrize(("layout", "count"), [("node", 10), ("vehicle", 6), ("single", 1)])
def test_processes_of_a_layout(layout, count):
    processes = process_specs(NODES, layout)
    assert len({process.name for process in processes}) == len(processes) == count
    assert len([process for process in processes if process.role == "relay"]) == 1
    assert len([process for process in processes if process.records]) == 1


def test_a_process_per_vehicle_holds_its_vehicle_and_its_agent():
    processes = {process.name: process for process in process_specs(NODES, "vehicle")}
    two = processes["/auv_2"]
    assert (two.role, two.vehicle_id) == ("vehicle", "auv_2")
    assert [node.name for node in two.nodes] == ["/auv_2/vehicle_node", "/auv_2/agent_node"]
    assert processes["/acoustic_relay_node"].vehicle_id == ""


@pytest.mark.parametrize("layout", LAYOUTS)
def test_nodes_may_have_any_layout_and_one_is_the_default(layout):
    assert check_layout(layout, mode="realtime", on_vehicle_loss="stop", vehicles=4) == layout
    assert check_layout(None, mode="inprocess", on_vehicle_loss="continue", vehicles=99) == DEFAULT_LAYOUT


@pytest.mark.parametrize(
    ("layout", "mode", "policy", "allowed"),
    [
        ("pair", "lockstep", "stop", "node, vehicle, single"),
        ("vehicle", "inprocess", "stop", "lockstep, realtime"),
        ("single", "lockstep", "continue", "node, vehicle"),
    ],
)
def test_a_layout_that_cannot_be_is_refused_in_one_line(layout, mode, policy, allowed):
    with pytest.raises(
        ConfigError, match=rf"layout '{layout}' is not allowed.*allowed.*: {allowed}"
    ) as refusal:
        check_layout(layout, mode=mode, on_vehicle_loss=policy, vehicles=4)
    assert len(str(refusal.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("layout", "most", "allowed"), [("node", 14, "vehicle, single"), ("vehicle", 29, "single")]
)
def test_more_processes_than_find_each_other_are_refused_in_one_line(layout, most, allowed):
    def check(vehicles, **more):
        return check_layout(layout, mode="lockstep", on_vehicle_loss="stop", vehicles=vehicles, **more)

    assert check(most) == layout
    assert check(most + 1, discovery="subnet") == layout
    with pytest.raises(
        ConfigError, match=rf"'{layout}' is not allowed for {most + 1} vehicles.*: {allowed}, or"
    ):
        check(most + 1)


def test_many_vehicles_may_share_one_process_but_not_any_number():
    def check(layout, vehicles):
        return check_layout(layout, mode="lockstep", on_vehicle_loss="stop", vehicles=vehicles)

    assert check("single", 128) == "single"
    with pytest.raises(
        ConfigError, match=r"for 129 vehicles.*; allowed: at most 128 vehicles, or mode inprocess"
    ):
        check("single", 129)
    with pytest.raises(
        ConfigError, match=r"for 129 vehicles.*; allowed: mode inprocess, or discovery subnet"
    ):
        check("vehicle", 129)
