"""Nodes started by hand say for whom they wait, refuse what they do not know, and end with their run."""

import subprocess

import pytest

pytest.importorskip("rclpy")

from rcl_interfaces.msg import Log
from ros_desk import desk, finish, process

from auv_bringup.compose import node_specs
from auv_bringup.node_start import write_params_file
from auv_bringup.scenario import load_scenario
from auv_msgs.msg import FlockStatus

pytestmark = pytest.mark.ros


def by_hand(folder, role, *arguments, mode="lockstep"):
    """Return what a process of the first node of a role is started with."""
    scenario = load_scenario("flock_acoustic")
    specs = node_specs(scenario, mode=mode, bag_dir=folder / "bag")
    spec = next(spec for spec in specs if spec.role == role)
    file = write_params_file(spec, folder)
    namespace = ("-r", f"__ns:={spec.namespace}")
    return (spec.module, "--ros-args", *namespace, "--params-file", file, *arguments)


def end_run(at, status, state):
    """Say several times that a run goes on, as its clock does, and then that it is over."""
    said = []
    timer = at.node.create_timer(0.1, lambda: said.append(status.publish(FlockStatus(state="running"))))
    at.until(lambda: len(said) > 5, "the clock speaks")
    timer.cancel()
    status.publish(FlockStatus(state=state))


def assert_ends(*children):
    for child in children:
        status, out, err = finish(child, None)
        assert status == 0, err
        assert "the run is over, so this process ends" in out + err


def test_nodes_name_whom_they_wait_for_and_end_with_the_run(tmp_path):
    with (
        desk() as at,
        process(*by_hand(tmp_path, "agent")) as agent,
        process(*by_hand(tmp_path, "vehicle")) as vehicle,
        process(*by_hand(tmp_path, "relay")) as relay,
        process(*by_hand(tmp_path, "recorder")) as recorder,
    ):
        said, status = at.listen(Log, "/rosout"), at.publisher(FlockStatus, "/flock/status", latched=True)

        def until_said(name, words):
            at.until(
                lambda: any(each.name == name and words in each.msg for each in said), f"{name}: {words}"
            )

        until_said("acoustic_relay_node", "waits for /auv_2/agent_node, /auv_3/agent_node, /auv_4/agent_node")
        until_said("recorder_node", "waits for /auv_2/vehicle_node, /auv_3/vehicle_node, /auv_4/vehicle_node")
        until_said("auv_1.agent_node", "waits for acoustic/rx of tick 0")
        until_said("auv_1.vehicle_node", "waits for a command for tick 0")
        finish(relay)  # its clock would say that the run still waits
        end_run(at, status, FlockStatus.FINISHED)
        assert_ends(agent, vehicle, recorder)


@pytest.mark.slow
def test_an_aborted_run_ends_its_nodes_and_an_earlier_one_does_not(tmp_path):
    with desk() as at, process(*by_hand(tmp_path, "agent")) as agent:
        status = at.publisher(FlockStatus, "/flock/status", latched=True)
        at.until(lambda: status.get_subscription_count() == 1, "the agent hears")
        status.publish(FlockStatus(state=FlockStatus.ABORTED))
        with pytest.raises(subprocess.TimeoutExpired):
            agent.wait(4.0)
        end_run(at, status, FlockStatus.ABORTED)
        assert_ends(agent)


@pytest.mark.parametrize(
    ("role", "name", "words"),
    [
        ("vehicle", "model.params.hull_radius", "allowed: model.params."),
        ("agent", "controller.params.k", "allowed: controller.params."),
        ("relay", "duration", "allowed: "),
        ("recorder", "bag", "allowed: bag_dir"),
    ],
)
def test_a_parameter_that_a_node_does_not_have_is_refused_before_anything_starts(role, name, words, tmp_path):
    with process(*by_hand(tmp_path, role, "-p", f"{name}:=1.0")) as child:
        returncode, _, err = finish(child, None)
    assert returncode == 2, err
    (line,) = [line for line in err.splitlines() if line.startswith("error: ")]
    assert f"unknown name '{name}'" in line
    assert words in line
    assert not (tmp_path / "bag").exists()
