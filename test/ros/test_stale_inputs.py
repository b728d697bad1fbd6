"""In real time no node acts on old inputs: it rests, reports that at once, and continues with fresh ones."""

import json
import os
import signal
import threading
import time
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from ros_desk import desk, finish, process

from auv_bringup.launching.node_specs import node_specs
from auv_bringup.launching.node_start import write_params_file
from auv_core.messages import VehicleState as State
from auv_experiment.scenario.loading import load_scenario
from auv_msgs.msg import AcousticInbox, VehicleState
from auv_ros.qos import own_qos
from auv_ros.wire import conversions as convert

pytestmark = pytest.mark.ros

LIMIT_S, PERIOD_S = 0.5, 0.1
# One period after the limit, and one more that a busy machine may miss.
WITHIN_S = LIMIT_S + 2.0 * PERIOD_S + 1e-6
OK, ERROR = b"\x00", b"\x02"
LAW, COMMAND, STATES = "agent_node: control law", "vehicle_node: command", "acoustic_relay_node: states"


def stamp_s(message):
    return message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec


class Watcher:
    """Reads diagnostics as an operator does."""

    def __init__(self, at):
        self._at = at
        self._heard = at.listen(DiagnosticArray, "/diagnostics")

    def wait(self, name, level, words):
        """Return the stamp (s) of the first status that says so from now on."""
        seen = len(self._heard)

        def found():
            return [
                stamp_s(array)
                for array in self._heard[seen:]
                for status in array.status
                if status.name.endswith(name) and status.level == level and words in status.message
            ]

        self._at.until(lambda: bool(found()), f"{name}: {words}")
        return found()[0]


def node(folder, role, epoch_s):
    """Write the parameters of a node that does not wait for others; return its command."""
    flown = load_scenario("ch2_pfpd_corrected", overrides=["sampling=sampled"])
    (spec,) = [spec for spec in node_specs(flown, mode="realtime", bag_dir=None) if spec.role == role]
    spec.params["epoch_s"] = epoch_s
    path = write_params_file(spec, folder)
    namespace = ("-r", f"__ns:={spec.namespace}")
    return (spec.module, "--ros-args", *namespace, "--params-file", path)


@pytest.mark.alone
def test_a_stopped_vehicle_or_agent_is_named_within_a_period_and_flown_on_with_afterwards(tmp_path):
    epoch_s = time.time()
    with (
        desk() as at,
        process(*node(tmp_path, "vehicle", epoch_s)) as vehicle,
        process(*node(tmp_path, "agent", epoch_s)) as agent,
    ):
        watcher, commands = Watcher(at), at.listen(WrenchStamped, "/auv_1/cmd_wrench")
        navs = at.listen(VehicleState, "/auv_1/nav")
        watcher.wait(LAW, OK, "acts")
        at.until(lambda: navs and commands and commands[-1].wrench.force.x != 0.0, "the vehicle is flown")

        os.kill(vehicle.pid, signal.SIGSTOP)
        held_s = watcher.wait(LAW, ERROR, "safe command: stale navigation: 0.")
        assert held_s - stamp_s(navs[-1]) <= WITHIN_S
        seen = len(commands)
        at.until(lambda: len(commands) > seen + 3, "commands go on")
        assert {(each.wrench.force.x, each.wrench.torque.z) for each in commands[seen:]} == {(0.0, 0.0)}
        os.kill(vehicle.pid, signal.SIGCONT)
        watcher.wait(LAW, OK, "acts")
        seen = len(commands)
        at.until(lambda: any(each.wrench.force.x for each in commands[seen:]), "the vehicle is flown again")
        watcher.wait(COMMAND, OK, "acts")  # it may have rested while it caught up

        os.kill(agent.pid, signal.SIGSTOP)
        rested_s = watcher.wait(COMMAND, ERROR, "the actuators rest: stale command: 0.")
        assert rested_s - stamp_s(commands[-1]) <= WITHIN_S + PERIOD_S  # its state is that of the next tick
        os.kill(agent.pid, signal.SIGCONT)
        watcher.wait(COMMAND, OK, "acts")
        for child, began, ended in (
            (agent, "holds, safe command: stale navigation", "acts again after"),
            (vehicle, "the actuators rest: stale command", "the actuators act again after"),
        ):
            status, out, err = finish(child)
            assert status == 0, err
            said = out + err
            assert said.index(began) < said.index(ended)


def test_a_navigation_of_a_far_tick_does_not_blind_the_agent(tmp_path):
    epoch_s = time.time()
    with desk() as at, process(*node(tmp_path, "agent", epoch_s)) as agent:
        watcher, commands = Watcher(at), at.listen(WrenchStamped, "/auv_1/cmd_wrench")
        nav_pub = at.publisher(VehicleState, "/auv_1/nav")
        stencil, far = (
            convert.state_stencil(),
            State(10**9, (0.0, 0.0, 10.0), (1.0, 0.0, 0.0, 0.0), (0.0,) * 6),
        )

        def say(state):
            nav_pub.publish(stencil.filled(time.time(), *convert.state_numbers(state)))

        def flown():
            say(far._replace(tick=int((time.time() - epoch_s) / PERIOD_S)))
            return len(commands) > 5 and commands[-1].wrench.force.x != 0.0

        at.until(flown, "the vehicle is flown")
        say(far)
        commands.clear()
        at.until(flown, "the vehicle is flown on")
        watcher.wait("agent_node: inputs", b"\x01", "navigation of tick 1000000000 at tick")
        assert finish(agent)[0] == 0


def test_a_vehicle_node_that_starts_anew_is_flown_on_with(tmp_path):
    epoch_s = time.time()
    with desk() as at, process(*node(tmp_path, "agent", epoch_s)) as agent:
        watcher = Watcher(at)
        with process(*node(tmp_path, "vehicle", epoch_s)) as vehicle:
            watcher.wait(LAW, OK, "acts")
            finish(vehicle)
            watcher.wait(LAW, ERROR, "stale navigation")
        with process(*node(tmp_path, "vehicle", epoch_s)) as vehicle:  # its ticks begin at 0 again
            watcher.wait(LAW, OK, "acts")
            assert finish(vehicle)[0] == 0
        assert finish(agent)[0] == 0


def test_a_relay_silences_the_modem_of_a_vehicle_whose_state_is_old(tmp_path):
    import rclpy

    epoch_s = time.time()
    with desk() as at, process(*node(tmp_path, "relay", epoch_s)) as relay:
        watcher = Watcher(at)
        ear = rclpy.create_node("agent_node", namespace="/auv_1", context=at.context, enable_rosout=False)
        ear.create_subscription(AcousticInbox, "acoustic/rx", lambda _: None, own_qos())
        at.executor.add_node(ear)
        state_pub = at.publisher(VehicleState, "/auv_1/state")
        stencil = convert.state_stencil()

        def say():
            tick = int((time.time() - epoch_s) / PERIOD_S)
            state = State(tick, (0.0, 0.0, 10.0), (1.0, 0.0, 0.0, 0.0), (0.0,) * 6)
            state_pub.publish(stencil.filled(time.time(), *convert.state_numbers(state)))

        timer = at.node.create_timer(PERIOD_S, say)
        watcher.wait(STATES, OK, "all fresh")
        timer.cancel()
        watcher.wait(STATES, ERROR, "modems silent: state of auv_1 0.")
        timer.reset()
        watcher.wait(STATES, OK, "all fresh")
        ear.destroy_node()
        assert finish(relay)[0] in (0, 3)


def pid_of(name, folder):
    """Return the process of a node of the run whose results are in a folder."""
    for entry in Path("/proc").iterdir():
        try:
            words = (
                (entry / "cmdline").read_bytes().decode(errors="replace") if entry.name.isdecimal() else ""
            )
        except OSError:
            continue
        if "node_container" in words and name in words and str(folder) in words:
            return int(entry.name)
    return None


@pytest.mark.alone
@pytest.mark.slow
def test_a_flight_goes_on_after_stops_and_its_metrics_count_them(tmp_path):
    flight = ("flock_acoustic", "--mode", "realtime", "--duration", "25", "--set", "answer_timeout_s=30")
    pause = threading.Event()

    def until(condition, what):
        deadline_s = time.monotonic() + 60.0
        while not condition():
            assert time.monotonic() < deadline_s, f"not yet: {what}"
            pause.wait(0.05)

    def until_logged(name, words):
        (log,) = tmp_path.glob(f"*/logs/{name}.log")
        until(lambda: words in log.read_text(), f"{name} says {words}")

    with process("auv_bringup.tools.run", *flight, "--no-figures", "--out", tmp_path) as run:
        until(lambda: any(p.stat().st_size > 300_000 for p in tmp_path.glob("*/bag/*.mcap")), "it flies")
        for stopped, told, held, freed in (
            ("auv_1.vehicle_node", "auv_1.agent_node", "stale navigation", "acts again"),
            ("auv_2.agent_node", "auv_2.vehicle_node", "stale command", "the actuators act again"),
        ):
            pid = pid_of(stopped, tmp_path)
            os.kill(pid, signal.SIGSTOP)
            try:
                until_logged(told, held)
            finally:
                os.kill(pid, signal.SIGCONT)
            until_logged(told, freed)
        status, out, err = finish(run, None)
    assert status == 0, out + err
    (metrics,) = [json.loads(path.read_text()) for path in tmp_path.glob("*/metrics.json")]
    assert metrics["safe_commands_stale_navigation"] > 0
    assert metrics["safe_commands_stale_command"] > 0
    assert not metrics["collision"]
