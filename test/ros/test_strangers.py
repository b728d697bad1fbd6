"""A foreign process on the graph can neither hold up nor end a run, and its messages do not get into it."""

import os
import signal
import time
from typing import Any

import pytest

pytest.importorskip("rclpy")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.executors import SingleThreadedExecutor
from ros_desk import desk, process
from std_msgs.msg import Int64

from auv_ros import strangers
from auv_ros.hearing import Hearing
from auv_ros.lifecycle import make_executor
from auv_ros.qos import EVERY_TICK, OWN_DEPTH, own_qos
from auv_ros.strangers import StrangerWatch
from auv_ros.topic import Topics
from auv_sim.nodes.link_reports import LinkReports

pytestmark = pytest.mark.ros

MESSAGES = 6 * OWN_DEPTH
"""More than the 5000 that the middleware keeps for a writer that keeps all messages."""


def test_a_reader_that_stalls_holds_no_writer(tmp_path):
    with desk() as at:
        publisher = at.publisher(Int64, "said")
        heard: list[Any] = []
        at.node.create_subscription(Int64, "said", heard.append, EVERY_TICK, raw=True)
        with process("auv_bringup.tools.topic", "hz", "/said") as echo:
            at.until(lambda: publisher.get_subscription_count() == 2, "both readers are found")
            os.kill(echo.pid, signal.SIGSTOP)
            longest_s = 0.0
            for number in range(MESSAGES):
                began_s = time.monotonic()
                publisher.publish(Int64(data=number))
                longest_s = max(longest_s, time.monotonic() - began_s)
                if number % 100 == 99:
                    at.until(lambda sent=number + 1: len(heard) == sent, "the own reader has everything")
    assert longest_s < 2.0  # less than the silence that a flight bears


@pytest.mark.parametrize(("publishers", "numbers"), [("own", [7]), ("any", [6, 7])])
def test_who_is_heard_is_the_runs_own_or_anybody(publishers, numbers):
    with desk() as at:
        stranger, own = at.stranger(Int64, "said"), at.publisher(Int64, "said")
        heard: list[Any] = []
        overheard = at.listen(Int64, "said")
        qos = own_qos(admits_strangers=publishers == "any")
        at.node.create_subscription(Int64, "said", heard.append, qos)
        at.until(lambda: stranger.get_subscription_count() == len(numbers), "discovery")
        at.until(lambda: own.get_subscription_count() == 2, "discovery")
        stranger.publish(Int64(data=6))
        at.until(lambda: len(overheard) == 1, "others hear the stranger")
        own.publish(Int64(data=7))
        at.until(lambda: len(overheard) == 2 and len(heard) == len(numbers), "everything is heard")
    assert sorted(message.data for message in heard) == numbers


@pytest.mark.parametrize("kind", [make_executor, SingleThreadedExecutor])
def test_writers_that_come_and_go_between_two_looks_are_counted(kind):
    with desk() as at, desk() as other:
        at.executor.remove_node(at.node)
        at.executor = kind(context=at.context)
        at.executor.add_node(at.node)
        hearing = Hearing(at.node)
        hearing.listen(Int64, "/auv_1/nav", lambda _: None, EVERY_TICK)
        hearing.listen(Int64, "/auv_1/state", lambda _: None, EVERY_TICK)
        own = at.publisher(Int64, "/auv_1/state")
        for number in (1, 2, 3):
            stranger = other.stranger(Int64, "/auv_1/nav")
            at.until(lambda seen=number: hearing.refused["/auv_1/nav"] == seen, "the writer is refused")
            other.node.destroy_publisher(stranger)
        at.until(lambda: own.get_subscription_count() == 1, "the own writer is heard")
    assert dict(hearing.refused) == {"/auv_1/nav": 3}


def heard_on(at, topic):
    """Return whether every publisher of the desk on a topic has a reader."""
    return all(each.get_subscription_count() for each in at.node.publishers if each.topic_name == topic)


def test_the_relay_tells_refused_writers_with_their_topics():
    with desk() as at:
        reports = LinkReports(Topics(at.node))
        said = at.listen(DiagnosticArray, "/diagnostics")
        at.until(lambda: heard_on(at, "/diagnostics"), "the reader")
        reports.tell_strangers([], {"/auv_1/state": 2}, 5.0, are_admitted=False)
        at.until(lambda: said, "the diagnostics")
    (status,) = said[0].status
    assert status.level == DiagnosticStatus.WARN
    assert [(each.key, each.value) for each in status.values] == [("writers_refused /auv_1/state", "2")]


def test_strangers_on_topics_of_a_run_are_named_once(monkeypatch):
    monkeypatch.setattr(strangers, "_NAMELESS_LOOKS", 10_000)  # looks follow each other at once here
    with desk() as at, desk() as other:
        for topic in ("/auv_1/nav", "/auv_1/state"):
            at.publisher(Int64, topic)
        watch = StrangerWatch(at.node, {"/desk"}, ["auv_1"])
        other.stranger(Int64, "/auv_1/nav")
        other.publisher(Int64, "/auv_1/state")
        other.stranger(Int64, "/clock")
        for topic in ("/chatter", "/tf", "/auv_10/nav"):
            other.stranger(Int64, topic)
        found: list[Any] = []

        def are_found():
            # Writers of nodes that an earlier test killed may still be known.
            found.extend(each for each in watch.look() if "/desk" in each.node)
            return len(found) == 4

        at.until(are_found, "the strangers")
        assert [each for each in watch.look() if "/desk" in each.node] == []
    assert sorted(stranger.words for stranger in found) == [
        "another /desk publishes /auv_1/nav: not heard",
        "another /desk publishes /clock: not heard",
        "one of two /desk publishes /auv_1/state: heard",
        "one of two /desk publishes /auv_1/state: heard",
    ]


def test_who_offers_what_the_run_offers_and_is_not_of_it_is_heard_and_named():
    with desk() as at:
        watch = StrangerWatch(at.node, {"/auv_1/agent_node"}, ["auv_1"])
        at.publisher(Int64, "/auv_1/nav")
        found: list[Any] = []

        def look():
            found.extend(each for each in watch.look() if each.node == "/desk")
            return found

        at.until(look, "the stranger")
    assert [stranger.words for stranger in found] == ["/desk publishes /auv_1/nav: heard"]
