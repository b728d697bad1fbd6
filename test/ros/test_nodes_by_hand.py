"""
Nodes started by hand name the nodes that they wait for, refuse unknown parameters, and end with their run.
"""

import struct
import subprocess
import time

import pytest

pytest.importorskip("rclpy")

from rcl_interfaces.msg import Log
from ros_desk import clock_library, desk, finish, process

from auv_bringup.launching.node_specs import node_specs
from auv_bringup.launching.node_start import write_params_file
from auv_experiment.scenario.loading import load_scenario
from auv_msgs.msg import FlockStatus, VehicleState
from auv_ros.run_config import RunConfig, TickClock
from auv_ros.wire import conversions as convert

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
    """Publish several times that a run goes on, like its clock, and then that it is over."""
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


@pytest.mark.parametrize("off_s", [-4, 1, pytest.param(4, marks=pytest.mark.slow)])
def test_a_node_whose_system_clock_is_off_acts_at_the_ticks_of_the_run(off_s, tmp_path, monkeypatch):
    shift = tmp_path / "shift"
    shift.write_bytes(struct.pack("=q", off_s))
    with desk() as at:
        clock = TickClock(RunConfig(mode="realtime"), 0.1, time.monotonic, time.time)
        status = at.publisher(FlockStatus, "/flock/status", latched=True)
        at.node.create_timer(0.2, lambda: status.publish(status_of(clock)))
        ahead = []
        relay, agent = at.another_node("acoustic_relay_node"), at.another_node("agent_node", "/auv_1")
        agent.create_subscription(VehicleState, "nav", lambda _: None, 10)
        relay.create_subscription(
            VehicleState, "/auv_1/state", lambda state: ahead.append(state.tick - clock.tick_now()), 10
        )
        monkeypatch.setenv("LD_PRELOAD", str(clock_library(tmp_path)))
        monkeypatch.setenv("CLOCK_SHIFT_FILE", str(shift))
        with process(*by_hand(tmp_path, "vehicle", "-p", "recorded:=false", mode="realtime")) as vehicle:
            at.until(lambda: status.get_subscription_count() == 2, "the vehicle hears that the run waits")
            clock.begin()
            at.until(lambda: len(ahead) > 20, "the vehicle moves")
            _, out, err = finish(vehicle)
    assert "off that of the run; this node follows the run's" in out + err
    assert -6 <= min(ahead) <= max(ahead) <= 1


def status_of(clock):
    """Return what the clock of a run says now."""
    if not clock.started:
        return FlockStatus(state=FlockStatus.WAITING, duration_s=600.0)
    tick = max(clock.tick_now(), 0)
    return FlockStatus(
        header=convert.header(clock.stamp_s(tick), ""),
        state=FlockStatus.RUNNING,
        tick=tick,
        time_s=clock.scenario_s(tick),
        duration_s=600.0,
    )


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
