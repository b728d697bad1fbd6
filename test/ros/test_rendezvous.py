"""Nodes find each other before a run begins, and no node that cannot be matched keeps them from it."""

import json
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

pytestmark = pytest.mark.ros

LIMIT_S = 20.0


@pytest.fixture
def ros():
    """Return a function that makes nodes and one that spins them until a condition holds."""
    import rclpy
    from rclpy.executors import SingleThreadedExecutor

    context = rclpy.Context()
    rclpy.init(context=context, args=[])
    executor, nodes = SingleThreadedExecutor(context=context), []

    def node(name):
        made = rclpy.create_node(name, context=context)
        nodes.append(made)
        executor.add_node(made)
        return made

    def spin_until(condition):
        deadline = time.monotonic() + LIMIT_S
        while not condition() and time.monotonic() < deadline:
            executor.spin_once(timeout_sec=0.05)
        return condition()

    yield node, spin_until
    for made in nodes:
        made.destroy_node()
    rclpy.shutdown(context=context)


def test_an_idle_executor_wakes_for_what_comes(ros):
    import rclpy
    from rclpy.task import Future
    from std_msgs.msg import Int64

    from auv_ros.lifecycle import make_executor
    from auv_ros.qos import EVERY_TICK

    node, spin_until = ros
    talker = node("talker")
    publisher = talker.create_publisher(Int64, "said", EVERY_TICK)
    context = rclpy.Context()
    rclpy.init(context=context, args=[])
    listener, heard = rclpy.create_node("listener", context=context), Future()
    listener.create_subscription(Int64, "said", heard.set_result, EVERY_TICK)
    executor = make_executor(context)
    executor.add_node(listener)
    assert spin_until(lambda: publisher.get_subscription_count() == 1)
    idle = threading.Thread(target=executor.spin_until_future_complete, args=(heard, LIMIT_S), daemon=True)
    idle.start()
    stat = Path(f"/proc/self/task/{idle.native_id}/stat")
    assert spin_until(lambda: stat.read_text().rsplit(")", 1)[1].split()[0] == "S")  # it sleeps
    publisher.publish(Int64(data=7))
    idle.join(LIMIT_S)
    assert not idle.is_alive()
    assert heard.result().data == 7
    listener.destroy_node()
    rclpy.shutdown(context=context)


def test_a_reader_that_asks_for_more_than_is_offered_keeps_nobody_waiting(ros):
    from std_msgs.msg import Int64

    from auv_ros.qos import EVERY_TICK, LATCHED
    from auv_ros.rendezvous import Rendezvous
    from auv_ros.topic import Topic

    node, spin_until = ros
    talker, listener, stranger = node("talker"), node("listener"), node("stranger")
    topic = Topic(talker, Int64, "said", heard_by=["/listener"])
    stranger.create_subscription(Int64, "said", lambda _: None, LATCHED)
    ready = []
    meeting = Rendezvous(talker, [topic], lambda: ready.append(True))
    assert spin_until(lambda: talker.count_subscribers("said") == 1)
    assert not meeting.ready
    assert meeting.missing() == ["/listener"]
    heard: list[Any] = []
    listener.create_subscription(Int64, "said", heard.append, EVERY_TICK)
    assert spin_until(lambda: bool(ready))
    topic.publish(Int64(data=7))
    assert spin_until(lambda: bool(heard))
    assert ready == [True]


def test_nodes_that_wait_do_not_ask_the_graph(ros, monkeypatch):
    """In a process of hundreds of nodes these questions were most of the start."""
    from std_msgs.msg import Int64

    from auv_ros.qos import EVERY_TICK
    from auv_ros.rendezvous import Rendezvous
    from auv_ros.topic import Topic

    node, spin_until = ros
    talker, listener = node("talker"), node("listener")
    asked = []
    for name in ("get_publishers_info_by_topic", "get_subscriptions_info_by_topic"):
        whole = getattr(talker, name)

        def ask(topic, whole=whole):
            asked.append(topic)
            return whole(topic)

        monkeypatch.setattr(talker, name, ask)
    topic = Topic(talker, Int64, "said", heard_by=["/listener"])
    ready = []
    Rendezvous(talker, [topic], lambda: ready.append(True))
    end_s = time.monotonic() + 0.3
    assert spin_until(lambda: time.monotonic() > end_s)
    assert (ready, asked) == ([], [])
    listener.create_subscription(Int64, "said", lambda _: None, EVERY_TICK)
    assert spin_until(lambda: bool(ready))
    assert asked


@pytest.mark.parametrize(("count", "has_services"), [(11, True), (257, False)])
def test_a_process_of_many_nodes_has_no_services_of_parameters(monkeypatch, count, has_services):
    from auv_bringup.launching.node_start import Part
    from auv_bringup.nodes import node_container

    made = []

    def make_nodes(**options):
        made.append(options)
        return [options]

    monkeypatch.setattr(node_container, "import_module", lambda _: SimpleNamespace(make_nodes=make_nodes))
    monkeypatch.setattr(node_container, "main_loop", lambda make_nodes, _: len(make_nodes()))
    assert node_container.run([Part("module", "/", "params.yaml")] * count) == count
    for options in made:
        assert options["start_parameter_services"] == has_services
        assert ("start_type_description_service:=false" in options["cli_args"]) != has_services


@pytest.mark.slow
def test_a_fleet_of_128_vehicles_flies_in_one_process(tmp_path):
    """It ended with status 3 before: its start took longer than the launcher waited."""
    run = subprocess.run(
        [
            sys.executable, "-m", "auv_bringup.tools.run", "swarm", "--mode", "lockstep", "--layout",
            "single",
            "--duration", "1", "--no-figures", "--out", str(tmp_path),
            "--set", "vehicles.count=128", "--set", "random_starts.radius_m=60",
        ],
        capture_output=True, text=True, timeout=500, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr[-2000:]
    (folder,) = tmp_path.iterdir()
    assert json.loads((folder / "metrics.json").read_text())["duration_s"] == 1.0


def test_readers_of_another_type_and_readers_that_never_match_do_not_keep_a_node_waiting(ros, monkeypatch):
    import rclpy
    from std_msgs.msg import Int64, String

    from auv_ros import rendezvous
    from auv_ros.qos import EVERY_TICK
    from auv_ros.rendezvous import Rendezvous
    from auv_ros.topic import Topic

    node, spin_until = ros
    talker, listener = node("talker"), node("listener")
    topic = Topic(talker, Int64, "said", heard_by=["/listener"])
    context = rclpy.Context()
    rclpy.init(context=context, args=[])
    stranger = rclpy.create_node("stranger", context=context)
    stranger.create_subscription(String, "said", lambda _: None, 10)
    assert spin_until(lambda: talker.count_subscribers("said") == 1)
    ready, late = [], []
    Rendezvous(talker, [topic], lambda: ready.append(True))
    listener.create_subscription(Int64, "said", lambda _: None, EVERY_TICK)
    assert spin_until(lambda: bool(ready))
    # A reader that the graph takes for one that matches, and that does not.
    monkeypatch.setattr(rendezvous, "_can_match", lambda offer, reader: True)
    monkeypatch.setattr(rendezvous, "_STRANGERS_S", 0.3)
    meeting = Rendezvous(talker, [topic], lambda: late.append(True))
    assert meeting.missing() == ["/listener"]
    assert spin_until(lambda: bool(late))
    stranger.destroy_node()
    rclpy.shutdown(context=context)
